/// What moved is no part of a cloud, nor what stood for long and has left.
#include <gtest/gtest.h>

#include "cloud_map/cloud_map_module.h"
#include "support/cloud_map_scans.h"
#include "support/run_program.h"
#include "support/traffic_log.h"

using namespace loopline;
using namespace loopline::cloud_map;
using namespace loopline::cloud_map_scans;

namespace {

/// 20 s: what is seen at the very end, no later sweep can tell to be gone.
constexpr const char* longer_street =
    "[simulation]\nseed = 3\nsensors = spinning_lidar\n[world]\ngenerator = town\n[route]\n"
    "drive = pushed\nwaypoint_m = 0 0\nwaypoint_m = 100 0\nwaypoint_m = 140 30\n[cart]\n"
    "speed_mps = 8\nspeed_up_s = 3\ncorner_radius_m = 12\nstandstill_s = 1\nend_standstill_s = 1\n"
    "[terrain]\nsigma_slope_deg = 2\n[spinning_lidar]\nbeams = 32\ncolumns = 360\nrate_hz = 5\n";

struct Removal {
    test::TrafficLog::Count all, kept;  ///< points without removal, and with it
};

/// By true poses.
Removal removal_of(test::TrafficLog& log) {
    CloudMapSettings settings;
    CloudMapper without(settings, 2);
    settings.removal.remove_moving = false;
    CloudMapper with(settings, 2);
    lidar::SpinningScanReader reader;
    lidar::SpinningScan scan;
    const PoseAt truth = [&](StampNs t) { return log.T_map_base(t); };
    log.for_each_sweep([&](const mrpt::obs::CObservation::Ptr& sweep) {
        if (!reader.read(*sweep, scan)) return;
        without.add(scan, {}, truth);
        with.add(scan, {}, truth);
    });
    without.finish();
    with.finish();
    return {log.count(with.cloud()), log.count(without.cloud())};
}

}  // namespace

TEST(CloudMapRemoval, leaves_out_the_traffic_of_a_town_and_keeps_what_stands) {
    const test::TemporaryFolder folder;
    const std::string scenario =
        folder.write("street.ini", std::string(longer_street) + "[traffic]\noncoming_s = 4\nahead = 0.8\n");
    test::TrafficLog log(scenario, {});
    const Removal removal = removal_of(log);
    EXPECT_GT(removal.all.moving, 5000u);
    EXPECT_LT(double(removal.kept.moving), 0.05 * double(removal.all.moving));
    EXPECT_GT(double(removal.kept.still), 0.99 * double(removal.all.still));
}

TEST(CloudMapRemoval, leaves_out_cars_that_stood_for_long_and_left_and_keeps_those_that_stay) {
    const test::TemporaryFolder folder;
    const std::string scenario =
        folder.write("street.ini", std::string(longer_street) +
                                       "[traffic]\noncoming_s = 0\nahead = 0\nstanding_per_km = 60\n[town]\n"
                                       "parked_per_km = 60\n");
    test::TrafficLog log(scenario, {});
    const Removal removal = removal_of(log);
    EXPECT_GT(removal.all.moving, 3000u);
    EXPECT_LT(double(removal.kept.moving), 0.1 * double(removal.all.moving));
    EXPECT_GT(double(removal.kept.still), 0.995 * double(removal.all.still));
}

namespace {

/// A room of 40 m, and in it a pillar and, as long as it stands there, a box.
lidar::SpinningScan room_from(double x_m, bool with_box, int k) {
    const auto range_to = [x_m](double cx_m, double cy_m, double half_m, double azimuth_rad) {
        double near_m = 0, far_m = 1e9;  // slabs
        const double from[] = {x_m, 0}, middle[] = {cx_m, cy_m},
                     along[] = {std::cos(azimuth_rad), std::sin(azimuth_rad)};
        for (int axis = 0; axis < 2; ++axis) {
            const double a = (middle[axis] - half_m - from[axis]) / along[axis],
                         b = (middle[axis] + half_m - from[axis]) / along[axis];
            near_m = std::max(near_m, std::min(a, b));
            far_m = std::min(far_m, std::max(a, b));
        }
        return near_m < far_m ? near_m > 0 ? near_m : far_m : 1e9;
    };
    auto scan = scan_of([&](double e, double a) {
        double level_m = range_to(0, 0, 20, a);
        level_m = std::min(level_m, range_to(2, -6, 0.15, a));
        if (with_box) level_m = std::min(level_m, range_to(3, 8, 1, a));
        return level_m / std::cos(e);
    });
    scan.stamp_ns = start_ns + 200'000'000LL * k;
    return scan;
}

}  // namespace

TEST(CloudMapRemoval, of_a_box_that_stood_for_a_minute_nothing_is_left_once_it_was_looked_through) {
    CloudMapSettings settings;
    for (const int seen : {6, 20, 60}) {
        CloudMapper mapper(settings, 1);
        int k = 0;
        for (; k < 5 * seen; ++k) mapper.add(room_from(0, true, k), {}, standing());
        // Seen through from the place of before, then on the way.
        for (int sweep = 0; sweep < 40; ++sweep) {
            const double x_m = std::max(0.0, 0.25 * (sweep - 10));
            mapper.add(room_from(x_m, false, k++), {},
                       standing({{x_m, 0, 0}, Eigen::Quaterniond::Identity()}));
        }
        mapper.finish();
        int of_box = 0, of_pillar = 0, of_wall = 0;
        for (const CloudPoint& point : mapper.cloud().points()) {
            const Eigen::Vector3d p = point.p_map_m();
            // What only the highest or lowest ring met, others can't look through.
            const bool between_rings = p.z() > -3.5 && p.z() < 1;
            of_box += between_rings && std::abs(p.x() - 3) < 1.1 && std::abs(p.y() - 8) < 1.1 ? 1 : 0;
            of_pillar += std::abs(p.x() - 2) < 0.2 && std::abs(p.y() + 6) < 0.2 ? 1 : 0;
            of_wall += p.y() > 19.8 && std::abs(p.x() - 3) < 2 ? 1 : 0;
        }
        EXPECT_EQ(of_box, 0) << seen;
        EXPECT_GT(of_pillar, 40) << seen;
        EXPECT_GT(of_wall, 100) << seen;  // behind the box, and seen only after it left
        EXPECT_GT(mapper.counts().moving, 200u) << seen;
    }
}
