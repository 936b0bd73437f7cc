/// What moved in a town is no part of its cloud, nor what stood for long and has left.
#include <gtest/gtest.h>

#include "cloud_map/cloud_mapper.h"
#include "lidar/observation_scan.h"
#include "support/run_program.h"
#include "support/traffic_log.h"

using namespace loopline;
using namespace loopline::cloud_map;

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
