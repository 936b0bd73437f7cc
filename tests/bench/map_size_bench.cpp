/// What a step of the line filter costs in maps of 100 to 3,000 lines, and beside it a step of MRPT's
/// CRangeBearingKFSLAM2D with 400 landmarks that are told apart by their numbers. Prints two tables; takes no
/// arguments.
#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CActionRobotMovement2D.h>
#include <mrpt/obs/CObservationBearingRange.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/slam/CRangeBearingKFSLAM2D.h>

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <random>
#include <vector>

#include "line_slam/line_ekf_slam.h"
#include "support/line_slam_world.h"

using namespace loopline;
using namespace loopline::line_slam;

namespace {

constexpr double step_m = 0.2, house_m = 5, range_m = 25;
constexpr int peer_landmarks = 400, peer_steps = 60;

double cpu_s() {
    timespec t{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

/// A straight street between houses that stand a little askew, one every 5 m on either side.
std::vector<test::WorldWall> street(int walls) {
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> depth_m(3, 5), turn(-0.05, 0.05);
    std::vector<test::WorldWall> houses;
    for (int i = 0; i < walls; ++i) {
        const double side = i % 2 == 0 ? 1 : -1, x_m = house_m * (i / 2), y_m = side * depth_m(random);
        const Eigen::Vector2d middle(x_m, y_m),
            half = 2.1 * side * Eigen::Vector2d(-std::cos(turn(random)), 0) +
                   Eigen::Vector2d(0, 2.1 * turn(random));
        houses.push_back({middle - half, middle + half});
    }
    return houses;
}

struct Cost {
    double mean_ms = 0, late_ms = 0, worst_ms = 0, seen = 0;
    int lines = 0;
    std::size_t local_maps = 0;
};

Cost drive(int walls) {
    std::mt19937_64 random(2);
    LineSlamParameters parameters;
    parameters.sigma_wall_m = 0;
    const auto houses = street(walls);
    LineEkfSlam slam(parameters);
    Pose2 T_world_base;
    WheelTravel travel;
    Cost cost;
    std::vector<double> steps_ms;
    const double end_m = house_m * walls / 2;
    while (T_world_base.x_m < end_m) {
        std::vector<LineObservation> seen;
        const auto from =
            static_cast<std::size_t>(std::max(0.0, 2 * ((T_world_base.x_m - range_m) / house_m)));
        const auto to =
            std::min(houses.size(), static_cast<std::size_t>(2 * ((T_world_base.x_m + range_m) / house_m)));
        for (std::size_t w = from; w < to; ++w) {
            LineObservation z;
            if (!test::view(houses[w], T_world_base, range_m, z)) continue;
            test::disturb(z, 0.01, random);
            seen.push_back(z);
        }
        cost.seen += static_cast<double>(seen.size());
        const double start_s = cpu_s();
        if (slam.step(moved(travel, parameters.drive.track_width_m), std::move(seen)) != SlamStatus::good)
            break;
        steps_ms.push_back(1e3 * (cpu_s() - start_s));
        const WheelTravel truth = wheel_travel({step_m, 0, 0}, parameters.drive.track_width_m);
        T_world_base = T_world_base * moved(truth, parameters.drive.track_width_m);
        travel = test::measured(truth, parameters.drive, {}, random);
    }
    for (const double ms : steps_ms) cost.mean_ms += ms / static_cast<double>(steps_ms.size());
    const std::size_t late = steps_ms.size() / 10;
    for (std::size_t k = steps_ms.size() - late; k < steps_ms.size(); ++k)
        cost.late_ms += steps_ms[k] / static_cast<double>(late);
    cost.worst_ms = *std::max_element(steps_ms.begin(), steps_ms.end());
    cost.seen /= static_cast<double>(steps_ms.size());
    for (int id = 0; id < slam.filter().line_ids(); ++id) cost.lines += slam.filter().exists(id);
    cost.local_maps = slam.filter().local_maps();
    return cost;
}

/// Landmarks on a line, of which those within reach are seen; the mean of the steps after all are in the map.
double peer_step_ms(int landmarks, double seen_each_side) {
    std::mt19937_64 random(3);
    std::normal_distribution<double> normal;
    mrpt::slam::CRangeBearingKFSLAM2D filter;
    filter.setMinLoggingLevel(mrpt::system::LVL_ERROR);
    filter.options.create_simplemap = false;
    const double spacing_m = 1;
    double x_m = 0, total_s = 0;
    int timed = 0;
    const int all_seen = landmarks;
    for (int step = 0; step < all_seen + peer_steps; ++step) {
        auto actions = mrpt::obs::CActionCollection::Create();
        mrpt::obs::CActionRobotMovement2D movement;
        mrpt::obs::CActionRobotMovement2D::TMotionModelOptions options;
        const double dx_m = step < all_seen ? spacing_m : -0.1;
        movement.computeFromOdometry(mrpt::poses::CPose2D(dx_m, 0, 0), options);
        actions->insert(movement);
        x_m += dx_m;
        auto observation = mrpt::obs::CObservationBearingRange::Create();
        observation->maxSensorDistance = 30;
        observation->sensor_std_range = 0.02f;
        observation->sensor_std_yaw = 0.005f;
        for (int i = 0; i < landmarks; ++i) {
            const double ahead_m = i * spacing_m - x_m, left_m = i % 2 == 0 ? 3 : -3;
            if (std::abs(ahead_m) > seen_each_side) continue;
            mrpt::obs::CObservationBearingRange::TMeasurement m;
            m.range = static_cast<float>(std::hypot(ahead_m, left_m) + 0.02 * normal(random));
            m.yaw = static_cast<float>(std::atan2(left_m, ahead_m) + 0.005 * normal(random));
            m.pitch = 0;
            m.landmarkID = i;
            observation->sensedData.push_back(m);
        }
        auto frame = mrpt::obs::CSensoryFrame::Create();
        frame->insert(observation);
        const double start_s = cpu_s();
        filter.processActionObservation(actions, frame);
        if (step >= all_seen) {
            total_s += cpu_s() - start_s;
            ++timed;
        }
    }
    return 1e3 * total_s / timed;
}

}  // namespace

int main() {
    std::printf("A street of houses, a step every %.1f m, CPU time of LineEkfSlam::step in ms:\n\n", step_m);
    std::printf("%8s %10s %12s %10s %18s %10s %10s\n", "walls", "in map", "local maps", "mean",
                "last tenth of way", "worst", "seen");
    double first_ms = 0, at_400_ms = 0, seen = 0, last_ms = 0;
    for (const int walls : {100, 300, 400, 1000, 3000}) {
        const Cost c = drive(walls);
        std::printf("%8d %10d %12zu %10.3f %18.3f %10.3f %10.1f\n", walls, c.lines, c.local_maps, c.mean_ms,
                    c.late_ms, c.worst_ms, c.seen);
        if (walls == 100) first_ms = c.mean_ms;
        if (walls == 400) at_400_ms = c.mean_ms, seen = c.seen;
        last_ms = c.mean_ms;
    }
    std::printf("\n3,000 against 100 walls: %.2f times the time of a step.\n\n", last_ms / first_ms);
    const double peer_ms = peer_step_ms(peer_landmarks, seen / 2);
    std::printf(
        "CRangeBearingKFSLAM2D, %d landmarks, %.0f seen a step: %.2f ms a step, %.0f times ours with 400 "
        "walls.\n",
        peer_landmarks, seen, peer_ms, peer_ms / at_400_ms);
}
