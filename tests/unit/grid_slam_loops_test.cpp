/// Loops on synthetic drives: the true one is found, and what only looks like one is not.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <map>

#include "grid_slam/active_map.h"
#include "grid_slam/grid_slam.h"
#include "grid_slam/loop_search.h"
#include "support/grid_slam_drive.h"

using namespace loopline;
using namespace loopline::grid_slam;

namespace {

constexpr double deg = M_PI / 180;
/// Of a scan, ten a second.
StampNs stamp(std::size_t k) {
    return static_cast<StampNs>(k) * 100'000'000;
}

/// A drive as the search for loops sees it: frames at dead-reckoned poses, chained by their motions.
class DeadReckonedDrive {
 public:
    DeadReckonedDrive(lines_world::World world, const grid_map_world::Sensor& sensor,
                      const std::vector<Pose2>& truth, const Eigen::Vector3d& sigma_per_step,
                      std::uint64_t seed)
        : world_(std::move(world)),
          sensor_(sensor),
          truth_(truth),
          random_(seed),
          motions_(test::noisy_motions(truth, sigma_per_step, random_)) {}

    /// Looks for a loop after every frame, up to the first one.
    void run() {
        for (std::size_t k = 0; k < truth_.size() && loop.empty(); ++k) {
            add(k);
            if (k % 5 == 0) active_.choose(map, graph_, map.last());
            loop = search.look(map, active_, graph_);
        }
    }
    Pose2 true_between(const Constraint& c) const { return truth_[c.from].inverse() * truth_[c.to]; }

    MapFrames map;
    LoopSearch search{{}};
    std::vector<Constraint> loop;

 private:
    void add(std::size_t k) {
        const grid_map::Frame frame = grid_map_world::frame_at(world_, truth_[k], sensor_, random_);
        const double way_m =
            k == 0 ? 0 : map.path_m.back() + motions_[k - 1].T_before_now.translation().norm();
        const Pose2 T = k == 0 ? Pose2{} : map.poses.back() * motions_[k - 1].T_before_now;
        map.add(frame, T, way_m, k, stamp(k), k == 0 ? Motion{} : motions_[k - 1]);
        graph_.resize(map.size());
        active_.add(map, map.last());
        if (k == 0) return;
        Constraint c;
        c.from = map.last() - 1;
        c.to = map.last();
        c.T_from_to = motions_[k - 1].T_before_now;
        c.information = motions_[k - 1].covariance.inverse();
        graph_.add(c, map.poses[c.from]);
    }

    lines_world::World world_;
    grid_map_world::Sensor sensor_;
    std::vector<Pose2> truth_;
    std::mt19937_64 random_;
    std::vector<Motion> motions_;
    ActiveMap active_{{0.05, false}, {}};
    Neighbourhood graph_;
};

const std::vector<Eigen::Vector2d> once_around{{0, 0}, {12, 0}, {12, 8}, {0, 8}, {0, 0}, {10, 0}};
const grid_map_world::Sensor sensor_270{271, 1.5 * M_PI, {0.2, 0, 0}, 0.01, 20};

TEST(LoopSearch, finds_a_loop_that_dead_reckoning_missed) {
    for (const std::uint64_t seed : {1, 2, 3}) {
        DeadReckonedDrive drive(test::ring_building(), sensor_270,
                                test::drive_along(once_around, 0.2, 10 * deg), {0.015, 0.01, 0.15 * deg},
                                seed);
        drive.run();
        ASSERT_GE(drive.loop.size(), 2U) << seed;
        EXPECT_EQ(drive.search.records().back().decision, LoopRecord::Decision::accepted);
        EXPECT_GT(drive.map.path_m.back(), 30) << "no loop before it was driven";
        double missed_m = 0;
        for (const Constraint& c : drive.loop) {
            const Pose2 off = drive.true_between(c).inverse() * c.T_from_to;
            // Both the old and the latest frames lie by dead reckoning: over 20 steps 0.7 degrees and 7 cm.
            EXPECT_LT(off.translation().norm(), 0.1) << seed;
            EXPECT_LT(std::abs(off.phi_rad), 1 * deg) << seed;
            const Pose2 reckoned = drive.map.poses[c.from].inverse() * drive.map.poses[c.to];
            missed_m = std::max(missed_m, (reckoned.inverse() * c.T_from_to).translation().norm());
        }
        EXPECT_GT(missed_m, 0.08) << seed;
    }
}

/// Two rooms alike, 16 m apart, with one and the same view of a passage between them.
lines_world::World twin_rooms() {
    lines_world::World world;
    for (const double x : {0.0, 16.0}) {
        const double walls[][4] = {{-3, -2, 3, -2},  {-3, 2, 3, 2},  {-3, -2, -3, -0.6}, {-3, 0.6, -3, 2},
                                   {3, -2, 3, -0.6}, {3, 0.6, 3, 2}, {1, 1, 1.8, 1},     {1, 1, 1, 1.8}};
        for (const auto& w : walls) world.walls.push_back({{x + w[0], w[1]}, {x + w[2], w[3]}});
    }
    for (const double y : {-0.6, 0.6})
        for (const double x : {-13.0, 3.0, 19.0}) world.walls.push_back({{x, y}, {x + 10, y}});
    return world;
}

TEST(LoopSearch, does_not_join_two_rooms_that_are_alike) {
    for (const std::uint64_t seed : {1, 2}) {
        grid_map_world::Sensor near_sighted = sensor_270;
        near_sighted.max_range_m = 6;
        DeadReckonedDrive drive(twin_rooms(), near_sighted,
                                test::drive_along({{-1.5, 0}, {17.5, 0}}, 0.2, 10 * deg),
                                {0.015, 0.01, 0.15 * deg}, seed);
        drive.run();
        EXPECT_TRUE(drive.loop.empty()) << seed;
        for (const LoopRecord& record : drive.search.records())
            EXPECT_NE(record.decision, LoopRecord::Decision::accepted);
    }
    // By their looks alone they would be one.
    std::mt19937_64 random(3);
    grid_map_world::Sensor exact = sensor_270;
    exact.max_range_m = 6;
    grid_map::ScanGrid one({});
    one.insert(grid_map_world::frame_at(twin_rooms(), {}, exact, random), {});
    const auto points =
        grid_map::search_points(grid_map_world::frame_at(twin_rooms(), {16, 0, 0}, exact, random), 100);
    EXPECT_GT(grid_map::branch_and_bound(one, points, {})->fit, LoopSettings{}.min_likelihood);
}

TEST(LoopSearch, refuses_a_corridor_without_features) {
    // There and back again, seeing no end of it.
    grid_map_world::Sensor near_sighted = sensor_270;
    near_sighted.max_range_m = 8;
    DeadReckonedDrive drive(grid_map_world::corridor(2, 0), near_sighted,
                            test::drive_along({{0, 0}, {12, 0}, {0, 0}}, 0.2, 10 * deg),
                            {0.03, 0.005, 0.1 * deg}, 1);
    drive.run();
    EXPECT_TRUE(drive.loop.empty());
    ASSERT_FALSE(drive.search.records().empty()) << "nothing was tried";
    std::size_t not_held = 0;
    for (const LoopRecord& record : drive.search.records()) {
        EXPECT_EQ(record.decision, LoopRecord::Decision::refused);
        not_held += record.reason == "the scans don't hold the pose in all directions";
    }
    EXPECT_GT(2 * not_held, drive.search.records().size());
}

// ---- All of it
// -------------------------------------------------------------------------------------------------------

struct Path {
    std::vector<Pose2> poses;
    std::vector<Eigen::Matrix3d> covariances;
    std::size_t loops = 0, frames = 0;
    std::uint64_t motions_refused = 0;
};

/// `slips`: what wheels say too much between a scan and the next one, many times their noise.
Path path_of_ring(const std::vector<Pose2>& truth, std::uint64_t seed, Weights weights = Weights::joint,
                  const std::map<std::size_t, Pose2>& slips = {}, double active_sigma_m = 0.05) {
    std::mt19937_64 random(seed);
    const auto world = test::ring_building();
    auto motions = test::noisy_motions(truth, {0.01, 0.01, 0.3 * deg}, random);
    for (const auto& [k, slip] : slips) motions[k].T_before_now = motions[k].T_before_now * slip;
    GridSlamSettings settings;
    settings.weights = weights;
    settings.active.sigma_m = active_sigma_m;  // 0.05: what is behind is soon too uncertain to match with
    GridSlam slam{settings};
    test::map_drive(slam, world, truth, motions, sensor_270, stamp, random);
    Path path;
    slam.path(path.poses, path.covariances);
    path.motions_refused = slam.motions_refused();
    path.frames = slam.map().size();
    for (const LoopRecord& record : slam.loops())
        path.loops += record.decision == LoopRecord::Decision::accepted;
    return path;
}

double rmse_m(const Path& path, const std::vector<Pose2>& truth) {
    const Pose2 T_map_world = truth[0].inverse();
    double squares = 0;
    for (std::size_t k = 0; k < truth.size(); ++k)
        squares += (path.poses[k].translation() - (T_map_world * truth[k]).translation()).squaredNorm();
    return std::sqrt(squares / static_cast<double>(truth.size()));
}

TEST(GridSlam, gives_the_path_of_a_ring_and_the_same_bytes_each_time) {
    const auto truth = test::drive_along(once_around, 0.1, 5 * deg);
    const Path path = path_of_ring(truth, 1), again = path_of_ring(truth, 1);
    ASSERT_EQ(path.poses.size(), truth.size());
    const Pose2 T_map_world = truth[0].inverse();
    double worst_rad = 0;
    for (std::size_t k = 0; k < truth.size(); ++k) {
        const Pose2 T = T_map_world * truth[k];
        worst_rad = std::max(worst_rad, std::abs(wrap_to_pi(path.poses[k].phi_rad - T.phi_rad)));
        EXPECT_EQ(path.poses[k].x_m, again.poses[k].x_m);
        EXPECT_EQ(path.poses[k].y_m, again.poses[k].y_m);
        EXPECT_EQ(path.poses[k].phi_rad, again.poses[k].phi_rad);
        EXPECT_EQ(path.covariances[k], again.covariances[k]);
        EXPECT_GE(path.covariances[k].diagonal().minCoeff(), 0);
    }
    EXPECT_LT(rmse_m(path, truth), 0.02);
    EXPECT_LT(worst_rad, 0.3 * deg);
    EXPECT_GE(path.loops, 1U);
}

TEST(GridSlam, a_map_takes_no_more_frames_once_its_places_are_known) {
    // Each lap runs a little beside the ones before, so that few scans are at the place of an earlier one.
    std::vector<std::size_t> frames;
    double rmse = 0;
    for (const int laps : {1, 2, 4}) {
        std::vector<Eigen::Vector2d> route{{0, 0}};
        for (int lap = 0; lap < laps; ++lap) {
            const double in = 0.11 * (lap % 2) + 0.04 * (lap / 2);
            route.insert(route.end(), {{12 - in, in}, {12 - in, 8 - in}, {in, 8 - in}, {in, in}});
        }
        const auto truth = test::drive_along(route, 0.1, 5 * deg);
        const Path path = path_of_ring(truth, 1, Weights::joint, {}, 0.3);
        frames.push_back(path.frames);
        rmse = rmse_m(path, truth);
    }
    EXPECT_LT(frames[1], 1.2 * static_cast<double>(frames[0]));
    EXPECT_LT(frames[2], 1.03 * static_cast<double>(frames[1]));
    EXPECT_LT(rmse, 0.02);
}

TEST(GridSlam, finds_scans_again_where_wheels_slipped_far_beyond_their_noise) {
    const auto truth = test::drive_along(once_around, 0.1, 5 * deg);
    for (const std::uint64_t seed : {1, 2, 3}) {
        const Path path = path_of_ring(truth, seed, Weights::joint,
                                       {{60, {0, 0, 6 * deg}},
                                        {110, {0.18, 0, 0}},
                                        {170, {0, 0, -8 * deg}},
                                        {260, {-0.1, 0.1, 5 * deg}}});
        EXPECT_LT(rmse_m(path, truth), 0.02) << "seed " << seed;
        EXPECT_EQ(path.motions_refused, 4U) << "seed " << seed;
    }
}

TEST(GridSlam, corrects_a_ring_by_going_back_through_it) {
    const auto truth = test::drive_along(once_around, 0.1, 5 * deg);
    for (const Weights weights : {Weights::linear, Weights::covariance}) {
        const Path path = path_of_ring(truth, 1, weights);
        EXPECT_LT(rmse_m(path, truth), 0.03);
        EXPECT_GE(path.loops, 1U);
    }
}

}  // namespace
