/// Parts of localisation in a finished cloud: the cloud as it is read, columns, the ground, the start.
#include <Eigen/Eigenvalues>
#include <fstream>
#include <map>
#include <random>

#include "cloud_localisation/sweep_from_above.h"
#include "output/stored_cloud_files.h"
#include "support/cloud_in_yard.h"
#include "support/run_program.h"

using namespace loopline;
using namespace loopline::cloud_localisation;
using namespace loopline::test;

namespace {

std::vector<Eigen::Vector3d> all_of(const PointFile& file) {
    std::vector<Eigen::Vector3d> points_m;
    file.for_each(1, [&](const Eigen::Vector3d& p_m) { points_m.push_back(p_m); });
    return points_m;
}

struct SampledSweep {
    std::vector<lidar_mapping::SweepPoint> points, matched;
};

SampledSweep sampled(const lidar::SpinningScan& scan) {
    SampledSweep sweep;
    lidar_mapping::ScanSampler sampler;
    sampler.sample(scan, {}, 0.25, sweep.points);
    sampler.thin_out(sweep.points, 1, sweep.matched);
    return sweep;
}

StartLook looked(const FrozenCloud& map, const std::vector<Rectangle>& world, const Pose3& T_map_base,
                 const StartRegion& region, const Twist3& velocity = {}) {
    std::mt19937_64 random(5);
    WorkerPool workers(1);
    const SampledSweep sweep = sampled(sweep_at(world, T_map_base, velocity, second_ns, random));
    return look_for_start(map, sweep.points, sweep.matched, velocity, region, {}, workers);
}

/// Where a receiver has the vehicle, `off_m` beside its true place.
StartRegion region_about(const Pose3& T_map_base, const Eigen::Vector3d& off_m, double sigma_m) {
    const FixInMap fix = fix_of(T_map_base, 0, sigma_m, off_m);
    StartRegion region;
    region.p_map_m = fix.p_map_m;
    region.p_base_m = fix.p_base_antenna_m;
    region.sigma_m = sigma_m;
    region.sigma_z_m = 2 * sigma_m;
    return region;
}

/// The yard without anything in it: turned by half a turn it is the same.
std::vector<Rectangle> empty_yard() {
    std::vector<Rectangle> world{{{-30, -20, 0}, {60, 0, 0}, {0, 40, 0}}};
    add_box(world, -30, -20, 60, 40, 8);
    return in_map(world);
}

}  // namespace

TEST(CloudLocalisationMap, is_read_from_each_format_as_it_was_written_near_and_far) {
    const TemporaryFolder folder;
    for (const double far_m : {0.0, 30000.0}) {
        SCOPED_TRACE(far_m);
        std::mt19937_64 random(3);
        std::uniform_real_distribution<double> place(-50, 50);
        StoredCloud cloud;
        for (int i = 0; i < 2000; ++i) {
            CloudPoint point;
            for (auto& x : point.place) x = static_cast<std::int32_t>((place(random) + far_m) * 1e4);
            cloud.push_back(point);
        }
        write_ply(folder / "a.ply", cloud);
        write_pcd(folder / "a.pcd", cloud);
        write_las(folder / "a.las", cloud);
        for (const char* name : {"a.ply", "a.pcd", "a.las"}) {
            const auto points_m = all_of(*open_point_file(folder / name));
            ASSERT_EQ(points_m.size(), cloud.points().size()) << name;
            for (std::size_t i = 0; i < points_m.size(); ++i)
                ASSERT_LT((points_m[i] - cloud.points()[i].p_map_m()).cwiseAbs().maxCoeff(), 1e-5) << name;
        }
    }
    folder.write("text.ply",
                 "ply\nformat ascii 1.0\nelement vertex 2\nproperty double x\nproperty double y\n"
                 "property double z\nend_header\n500000.125 1 2\n3 4 5\n");
    const auto text_m = all_of(*open_point_file(folder / "text.ply"));
    ASSERT_EQ(text_m.size(), 2U);
    EXPECT_EQ(text_m[0].x(), 500000.125) << "no float has room for that";
}

TEST(CloudLocalisationMap, columns_are_those_of_brute_force) {
    std::mt19937_64 random(9);
    std::uniform_real_distribution<double> place(-40, 40), height(-2, 2);
    UprightColumns columns;
    std::map<std::pair<long, long>, std::pair<float, float>> expected;
    for (int i = 0; i < 30000; ++i) {
        const Eigen::Vector3d p_m(place(random), place(random), height(random));
        columns.add(p_m);
        const auto z_m = static_cast<float>(p_m.z());
        const auto [it, is_new] = expected.try_emplace(
            {std::lround(std::floor(p_m.x() / 0.5)), std::lround(std::floor(p_m.y() / 0.5))}, z_m, z_m);
        it->second = {std::min(it->second.first, z_m), std::max(it->second.second, z_m)};
    }
    EXPECT_EQ(columns.size(), expected.size());
    int upright = 0;
    for (const auto& [key, span] : expected) {
        const auto* column = columns.find(static_cast<int>(key.first), static_cast<int>(key.second));
        ASSERT_NE(column, nullptr);
        EXPECT_EQ(column->low_m, span.first);
        EXPECT_EQ(column->high_m, span.second);
        upright += column->is_upright() ? 1 : 0;
    }
    EXPECT_GT(upright, 100);
    EXPECT_EQ(columns.find(100, 100), nullptr);
    // How near the next upright one is, at the middle of each cell.
    const UprightField field(columns, {1, 2}, 12);
    for (int y = -15; y < 25; ++y)
        for (int x = -20; x < 22; ++x) {
            double nearest_m = 1e9;
            for (int dy = -8; dy <= 8; ++dy)
                for (int dx = -8; dx <= 8; ++dx) {
                    const auto* column = columns.find(x + dx, y + dy);
                    if (column != nullptr && column->is_upright())
                        nearest_m = std::min(nearest_m, 0.5 * std::hypot(dx, dy));
                }
            const double expected_value =
                nearest_m > 2.3 ? 0 : 255 * std::exp(-nearest_m * nearest_m / (2 * 0.49));
            EXPECT_NEAR(field.at(static_cast<float>(0.5 * x + 0.25), static_cast<float>(0.5 * y + 0.25)),
                        expected_value, nearest_m > 2 ? 5 : 0.51);
        }
}

TEST(CloudLocalisationStart, puts_the_vehicle_on_the_ground_as_it_leans_there_whatever_stands_on_it) {
    // Ground with a slope, and things whose lowest point is not on it.
    std::mt19937_64 random(2);
    std::uniform_real_distribution<double> place(-20, 20);
    const Pose3 T_map_base({3, -2, 0.7}, Eigen::AngleAxisd(0.9, Eigen::Vector3d::UnitZ()) *
                                             Eigen::AngleAxisd(0.05, Eigen::Vector3d::UnitY()) *
                                             Eigen::AngleAxisd(-0.03, Eigen::Vector3d::UnitX()));
    UprightColumns map;
    std::vector<Eigen::Vector3f> lowest_base_m;
    for (int i = 0; i < 800; ++i) {
        const Eigen::Vector3d p_base(place(random), place(random), 0);
        const Eigen::Vector3d p_map = T_map_base * p_base;
        map.add(p_map + Eigen::Vector3d(0, 0, i % 5 == 0 ? 1.5 : 0));
        lowest_base_m.push_back(p_base.cast<float>());
    }
    const auto found = on_ground(map, lowest_base_m, T_map_base.planar());
    ASSERT_TRUE(found);
    // Columns are half a metre wide: on a slope their lowest points are below their middles.
    EXPECT_NEAR(found->translation_m.z(), 0.7, 0.05);
    EXPECT_LT(turn_between_rad(*found, T_map_base), 0.01);
    EXPECT_FALSE(on_ground(UprightColumns(), lowest_base_m, T_map_base.planar()));
}

TEST(CloudLocalisationStart, is_found_for_any_heading_standing_or_moving) {
    const auto world = in_map(walled_yard());
    const FrozenCloud map = cloud_of(world);
    const Twist3 moving{{6, 0, 0}, {0, 0, 0.2}};
    int k = 0;
    for (const double yaw_deg : {0.0, 71.0, 168.0, -137.0, -45.5}) {
        SCOPED_TRACE(yaw_deg);
        const Pose3 T_map_base = level_pose(-2 + k, 0.5 * k, yaw_deg * M_PI / 180);
        const auto region = region_about(T_map_base, {1.7, -2.2, 3}, 2);
        const StartLook look = looked(map, world, T_map_base, region, k % 2 == 0 ? Twist3{} : moving);
        EXPECT_TRUE(look.found) << look.reason << ", " << look.fit << " against " << look.rival_fit;
        EXPECT_LT((look.state.T_map_base.translation_m - T_map_base.translation_m).norm(), 0.03);
        EXPECT_LT(turn_between_rad(look.state.T_map_base, T_map_base), 0.2 * M_PI / 180);
        ++k;
    }
}

TEST(CloudLocalisationStart, is_not_taken_where_two_headings_fit_or_nothing_does) {
    const auto yard = in_map(walled_yard()), empty = empty_yard();
    const FrozenCloud map = cloud_of(yard), empty_map = cloud_of(empty);
    const Pose3 middle = level_pose(0.2, 0.1, 0.4), other = level_pose(-6, -5, 2);
    const StartLook twice = looked(empty_map, empty, middle, region_about(middle, {0, 0, 0}, 1));
    EXPECT_FALSE(twice.found);
    EXPECT_EQ(twice.reason, "several places fit");
    // If the heading is known about, it is one of them.
    StartRegion heading = region_about(middle, {0.5, 0.3, 0}, 1);
    heading.yaw_rad = middle.yaw_rad() + 0.15;
    heading.sigma_yaw_rad = 0.2;
    const StartLook once = looked(empty_map, empty, middle, heading);
    EXPECT_TRUE(once.found) << once.reason;
    EXPECT_LT(turn_between_rad(once.state.T_map_base, middle), 0.2 * M_PI / 180);

    EXPECT_FALSE(looked(map, in_map(endless_corridor()), other, region_about(other, {0, 0, 0}, 1)).found);
    EXPECT_EQ(looked(map, empty, middle, region_about(other, {0, 0, 0}, 0.5)).reason, "no place there fits");
    // The yard reaches 30 m up to there.
    const std::string far = looked(map, yard, other, region_about(other, {0, 900, 0}, 1)).reason;
    EXPECT_EQ(far.substr(0, 14) + far.substr(16), "it should be 8 m outside of the map") << far;
    EXPECT_EQ(looked(map, yard, other, region_about(other, {0, 0, 0}, 50)).reason,
              "the place is known to 50 m only");
    EXPECT_EQ(looked(map, {yard[0]}, other, region_about(other, {0, 0, 0}, 1)).reason,
              "too little stands upright around the vehicle");
}

TEST(CloudLocalisationStart, is_the_same_for_any_number_of_threads) {
    const auto world = in_map(walled_yard());
    const FrozenCloud map = cloud_of(world);
    std::mt19937_64 random(5);
    const Pose3 T_map_base = level_pose(4, -3, 1);
    const SampledSweep sweep = sampled(sweep_at(world, T_map_base, {}, second_ns, random));
    const auto region = region_about(T_map_base, {0.4, 0.4, 0}, 0.5);
    WorkerPool one(1), three(3);
    const StartLook a = look_for_start(map, sweep.points, sweep.matched, {}, region, {}, one),
                    b = look_for_start(map, sweep.points, sweep.matched, {}, region, {}, three);
    EXPECT_EQ(a.state.T_map_base.translation_m, b.state.T_map_base.translation_m);
    EXPECT_EQ(a.fit, b.fit);
    EXPECT_EQ(a.rival_fit, b.rival_fit);
}

// ---- what the map's own path knows of its place ----

namespace {

PathFiles path_files(const TemporaryFolder& folder, const std::string& trajectory,
                     const std::string& covariance) {
    return {folder.write("trajectory.tum", trajectory),
            folder.write("covariance.csv", "header\n" + covariance)};
}

/// Of a diagonal covariance.
std::string covariance_row(const std::string& stamp, const std::vector<std::string>& diagonal) {
    std::string row = stamp;
    for (std::size_t i = 0; i < 6; ++i)
        for (std::size_t j = 0; j < 6; ++j) row += "," + (i == j ? diagonal[i] : "0");
    return row + "\n";
}

}  // namespace

TEST(CloudLocalisationMap, lies_as_well_as_the_path_that_it_was_drawn_by) {
    const TemporaryFolder folder;
    const std::vector<std::string> fine{"1e-4", "1e-4", "4e-4", "0", "0", "1e-6"},
        rough{"1", "4", "9", "0", "0", "0"};
    const MapUncertainty uncertainty(path_files(
        folder,
        "# a path\n1.000000000 0 0 0 0 0 0 1\n2.000000000 1 0 0 0 0 0 1\n3.000000000 50 0 0 0 0 0 1\n",
        covariance_row("1.000000000", fine) + covariance_row("2.000000000", rough) +
            covariance_row("3.000000000", rough)));
    ASSERT_TRUE(uncertainty.is_known());
    EXPECT_EQ(uncertainty.at({40, 3, 0})(1, 1), 4) << "of the nearest pose";
    // 20 m ahead of it, a heading that errs by 1 mrad errs by 2 cm to the side.
    const Matrix6d ahead = uncertainty.at({20, 0, 0});
    EXPECT_NEAR(ahead(0, 0), 1e-4, 1e-15);
    EXPECT_NEAR(ahead(1, 1), 1e-4 + 4e-4, 1e-12);
    EXPECT_NEAR(ahead(1, 5), 20 * 1e-6, 1e-12);
    EXPECT_FALSE(MapUncertainty().is_known());
    EXPECT_EQ(MapUncertainty().at({1, 2, 3}).norm(), 0);
}

TEST(CloudLocalisationMap, a_path_and_covariances_of_two_runs_are_refused) {
    const TemporaryFolder folder;
    const std::vector<std::string> any(6, "1");
    for (const std::string& row : {covariance_row("1.5", any), std::string(), std::string("1,2,3\n"),
                                   covariance_row("1", {"1", "1", "x", "1", "1", "1"})}) {
        const auto files = path_files(folder, "1 0 0 0 0 0 0 1\n", row);
        try {
            MapUncertainty read(files);
            FAIL() << row;
        } catch (const std::runtime_error& error) {
            EXPECT_NE(std::string(error.what()).find("does not fit"), std::string::npos) << error.what();
        }
    }
}
