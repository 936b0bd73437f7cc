/// The occupancy grid: what is hit is occupied, and nothing else, whatever way the scanner is mounted.
#include <gtest/gtest.h>
#include <mrpt/obs/CObservationOdometry.h>

#include <cmath>
#include <limits>

#include "maps/grid_module.h"
#include "maps_test_support.h"

using namespace loopline;
using namespace maps_test;
using mrpt::maps::COccupancyGridMap2D;
using mrpt::poses::CPose3D;

namespace {

constexpr double pi = M_PI;

COccupancyGridMap2D::Ptr draw_grid(const std::vector<StreamItem>& items, const Trajectory& trajectory,
                                   Results& results,
                                   const std::vector<std::pair<std::string, std::string>>& settings = {}) {
    GridMapBuilder builder;
    for (const auto& [key, value] : settings) set(builder, key, value);
    builder.start({}, trajectory);
    for (const auto& item : items) builder.insert(item);
    builder.finish(results);
    return only_map<COccupancyGridMap2D>(results);
}

std::vector<Eigen::Vector2d> cells_where(const COccupancyGridMap2D& grid, bool (*condition)(float free)) {
    std::vector<Eigen::Vector2d> found;
    for (unsigned y = 0; y < grid.getSizeY(); ++y)
        for (unsigned x = 0; x < grid.getSizeX(); ++x)
            if (condition(grid.getCell(static_cast<int>(x), static_cast<int>(y))))
                found.emplace_back(grid.idx2x(x), grid.idx2y(y));
    return found;
}

bool is_occupied(float free) {
    return free < 0.4f;
}

/// Every occupied cell holds a return, and the cell of every return is occupied. (Beams are so few that none
/// crosses another's end.)
void expect_occupied_where_hit(const COccupancyGridMap2D& grid, const std::vector<Eigen::Vector3d>& returns,
                               std::size_t may_be_crossed) {
    const double half_cell = 0.58 * grid.getResolution();  // MRPT adds up its angles in floats
    const auto near = [half_cell](const Eigen::Vector2d& cell, const Eigen::Vector3d& p) {
        return std::abs(cell.x() - p.x()) < half_cell && std::abs(cell.y() - p.y()) < half_cell;
    };
    const auto occupied = cells_where(grid, is_occupied);
    for (const auto& cell : occupied)
        EXPECT_TRUE(std::any_of(returns.begin(), returns.end(), [&](const auto& p) { return near(cell, p); }))
            << cell.transpose();
    std::size_t missed = 0;
    for (const auto& p : returns)
        missed += std::none_of(occupied.begin(), occupied.end(), [&](const auto& c) { return near(c, p); });
    EXPECT_LE(missed, may_be_crossed) << "of " << returns.size();
}

Trajectory at(const Pose2& T_map_base) {
    Trajectory trajectory;
    trajectory.append(1, 1000, Pose3(T_map_base), Matrix6d::Identity());
    return trajectory;
}

}  // namespace

TEST(MapsGrid, every_beam_ends_in_its_own_cell_however_the_scanner_is_mounted) {
    std::mt19937_64 random(1);
    const Pose2 T_map_base{3.2, -1.7, 2.1};
    const CPose3D T_map_base_mrpt(3.2, -1.7, 0, 2.1, 0, 0);
    const CPose3D mounts[] = {
        {}, {0.4, 0.1, 0.3, 0.7, 0, 0}, {0.4, -0.1, 0.3, -2.9, 0, pi}, {0, 0, 0, 0, pi, 0.02}};
    for (const auto& mount : mounts)
        for (const bool counter_clockwise : {true, false})
            for (const double aperture : {pi, 1.5 * pi, 2 * pi}) {
                // First and last beam always have a return: that is where a wrong angle step shows.
                auto ranges = sparse_ranges(181, 20, random);
                ranges.front() = 11;
                ranges.back() = 24;
                const auto scan = scan_of(ranges, aperture, mount, counter_clockwise);
                Results results;
                const auto grid = draw_grid({item_of(1, scan)}, at(T_map_base), results);
                expect_occupied_where_hit(*grid, points_in_map(*scan, T_map_base_mrpt), aperture > 6 ? 1 : 0);
            }
}

TEST(MapsGrid, cells_on_the_way_are_free_and_cells_behind_are_unknown) {
    const auto scan = scan_of({0, 5, 0}, pi);
    Results results;
    const auto grid = draw_grid({item_of(1, scan), item_of(2, scan), item_of(3, scan)}, at({}), results);
    for (double x = 0.1; x < 4.9; x += 0.1) EXPECT_GT(grid->getPos(static_cast<float>(x), 0.0f), 0.6f) << x;
    EXPECT_LT(grid->getPos(5.02f, 0.0f), 0.2f);
    for (const float x : {5.2f, 6.0f, -0.5f}) EXPECT_FLOAT_EQ(grid->getPos(x, 0.0f), 0.5f) << x;
    EXPECT_FLOAT_EQ(grid->getPos(2.0f, 0.5f), 0.5f);
    EXPECT_LT(grid->getSizeX(), 110u) << "cut to what was seen";
    EXPECT_LT(grid->getSizeY(), 10u);
}

TEST(MapsGrid, a_room_seen_from_many_places_has_its_walls_and_only_them) {
    // 8 m x 6 m, corner in the origin.
    const auto range_in_room = [](const Pose2& T_map_sensor, double angle) {
        const double a = T_map_sensor.phi_rad + angle, c = std::cos(a), s = std::sin(a);
        double r = 1e9;
        if (c > 1e-9) r = std::min(r, (8 - T_map_sensor.x_m) / c);
        if (c < -1e-9) r = std::min(r, -T_map_sensor.x_m / c);
        if (s > 1e-9) r = std::min(r, (6 - T_map_sensor.y_m) / s);
        if (s < -1e-9) r = std::min(r, -T_map_sensor.y_m / s);
        return r;
    };
    std::mt19937_64 random(2);
    std::uniform_real_distribution<double> x(1, 7), y(1, 5), angle(-pi, pi);
    Trajectory trajectory;
    std::vector<StreamItem> items;
    for (std::uint64_t i = 0; i < 60; ++i) {
        const Pose2 T_map_base{x(random), y(random), angle(random)};
        std::vector<float> ranges;
        for (int b = 0; b < 361; ++b)
            ranges.push_back(static_cast<float>(range_in_room(T_map_base, (b / 360.0 - 0.5) * 1.5 * pi)));
        trajectory.append(i, static_cast<StampNs>(i), Pose3(T_map_base), Matrix6d::Zero());
        items.push_back(item_of(i, scan_of(ranges, 1.5 * pi)));
    }
    for (const char* widen : {"false", "true"}) {
        Results results;
        const auto grid = draw_grid(items, trajectory, results, {{"widen_beams", widen}});
        for (const auto& cell : cells_where(*grid, is_occupied)) {
            const double off = std::min(
                {std::abs(cell.x()), std::abs(8 - cell.x()), std::abs(cell.y()), std::abs(6 - cell.y())});
            EXPECT_LT(off, 0.08) << cell.transpose();
        }
        int wall = 0, seen = 0;
        for (float along = 0.5f; along < 5.5f; along += 0.05f, ++wall)
            for (const float across : {7.975f, 8.025f})
                if (is_occupied(grid->getPos(across, along))) {
                    ++seen;
                    break;
                }
        EXPECT_GT(seen, 0.95 * wall);
        for (float cx = 0.5f; cx < 7.5f; cx += 0.25f)
            for (float cy = 0.5f; cy < 5.5f; cy += 0.25f)
                EXPECT_GT(grid->getPos(cx, cy), 0.9f) << cx << " " << cy;
    }
}

TEST(MapsGrid, scans_beyond_the_tilt_tolerance_are_left_out) {
    const auto level = scan_of({5, 5, 5}, pi, CPose3D(0, 0, 0, 0, 0, mrpt::DEG2RAD(4.0)));
    const auto tilted = scan_of({5, 5, 5}, pi, CPose3D(0, 0, 0, 0, mrpt::DEG2RAD(6.0), 0));
    Results one, none;
    EXPECT_FALSE(cells_where(*draw_grid({item_of(1, level)}, at({}), one), is_occupied).empty());
    EXPECT_TRUE(cells_where(*draw_grid({item_of(1, tilted)}, at({}), none), is_occupied).empty());
    EXPECT_EQ(one.metrics.count("grid_scans_left_out"), 0u);
    EXPECT_EQ(std::get<std::int64_t>(none.metrics.at("grid_scans_left_out")), 1);
}

TEST(MapsGrid, an_absurd_pose_is_left_out_and_the_rest_is_drawn) {
    Trajectory trajectory;
    const double nan = std::numeric_limits<double>::quiet_NaN();
    trajectory.append(1, 0, Pose3(Pose2{1e12, 0, 0}), Matrix6d::Zero());
    trajectory.append(2, 0, Pose3(Pose2{0, 0, 0}), Matrix6d::Zero());
    trajectory.append(3, 0, Pose3(Pose2{40000, 40000, 0}), Matrix6d::Zero());
    trajectory.append(4, 0, Pose3(Pose2{nan, 0, 0}), Matrix6d::Zero());
    trajectory.append(5, 0, Pose3(Pose2{1, 0, 0}), Matrix6d::Zero());
    const auto scan = scan_of({0, 5, 0}, pi);
    std::vector<StreamItem> items;
    for (std::uint64_t i = 1; i <= 5; ++i) items.push_back(item_of(i, scan));
    Results results;
    const auto grid = draw_grid(items, trajectory, results);
    EXPECT_EQ(cells_where(*grid, is_occupied).size(), 2u);
    EXPECT_EQ(std::get<std::int64_t>(results.metrics.at("grid_scans_left_out")), 2);
    EXPECT_LT(grid->getSizeX() * grid->getSizeY(), 1000u);
}

TEST(MapsGrid, the_cell_limit_holds_and_is_used_up_to_the_last_scan_that_fits) {
    Trajectory trajectory;
    std::vector<StreamItem> items;
    for (std::uint64_t i = 0; i < 40; ++i) {
        trajectory.append(i, 0, Pose3(Pose2{5.0 * static_cast<double>(i), 0, 0}), Matrix6d::Zero());
        items.push_back(item_of(i, scan_of({0, 1, 0}, pi)));
    }
    Results results;
    const auto grid =
        draw_grid(items, trajectory, results, {{"resolution_m", "0.1"}, {"max_cells", "100000"}});
    // The grid is about 54 cells high around the beam, or 254 with room to spare: between 39 and 185 m fit.
    const auto drawn = 40 - std::get<std::int64_t>(results.metrics.at("grid_scans_left_out"));
    EXPECT_EQ(static_cast<std::int64_t>(cells_where(*grid, is_occupied).size()), drawn);
    EXPECT_GE(drawn, 5);
    EXPECT_LE(drawn, 38);
}

TEST(MapsGrid, what_is_no_scan_or_has_no_pose_or_no_number_is_skipped) {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    auto odd = scan_of({5, 5, 5}, pi);
    odd->setScanRange(0, nan);
    odd->setScanRange(1, std::numeric_limits<float>::infinity());
    odd->setScanRange(2, -4);
    Results results;
    const auto grid =
        draw_grid({item_of(1, mrpt::obs::CObservationOdometry::Create()), item_of(7, scan_of({5, 5, 5}, pi)),
                   item_of(1, odd), item_of(1, mrpt::obs::CObservation2DRangeScan::Create())},
                  at({}), results);
    EXPECT_TRUE(cells_where(*grid, [](float free) { return free != 0.5f; }).empty());
}

TEST(MapsGrid, final_poses_are_used_not_those_known_at_the_time) {
    Trajectory trajectory = at({});
    trajectory.revise(0, Pose3(Pose2{0, 3, 0}), Matrix6d::Zero());
    Results results;
    const auto grid = draw_grid({item_of(1, scan_of({0, 5, 0}, pi))}, trajectory, results);
    ASSERT_EQ(cells_where(*grid, is_occupied).size(), 1u);
    EXPECT_NEAR(cells_where(*grid, is_occupied)[0].y(), 3, 0.05);
}
