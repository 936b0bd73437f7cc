/// The simulated sensors in MRPT's own rawlog-grabber: the same observations as in a simulated log.
#include <gtest/gtest.h>
#include <mrpt/obs/CObservation2DRangeScan.h>

#include <map>

#include "api/stamp.h"
#include "pipeline/log_source.h"
#include "support/plugin_environment.h"
#include "support/run_program.h"

using namespace loopline;
using namespace loopline::test;

namespace {

const char* const scenario = R"([simulation]
sensors = wheels horizontal_laser
[world]
wall_m = -1 -1  60 -1  60 1  -1 1  -1 -1
[route]
waypoint_m = 0 0
waypoint_m = 50 0
)";

std::string section(const std::string& name, const std::string& file) {
    return "[" + name + "]\ndriver = CSimulatedSensor\nprocess_rate = 100\nsensor = " + name +
           "\nscenario = " + file + "\nset = simulation.seed=3\nspeed = 5\n";
}

std::map<StampNs, mrpt::obs::CObservation2DRangeScan::ConstPtr> scans_of(const std::string& rawlog) {
    std::map<StampNs, mrpt::obs::CObservation2DRangeScan::ConstPtr> scans;
    LogSource source({rawlog});
    for (StreamItem item; source.next(item);)
        if (const auto scan =
                std::dynamic_pointer_cast<const mrpt::obs::CObservation2DRangeScan>(item.observation))
            scans[item.stamp_ns] = scan;
    return scans;
}

}  // namespace

TEST(SimulatedSensors, are_hosted_by_rawlog_grabber) {
    const std::string plugin = test::plugin_folder() + "/grabber/libloopline_simulated_sensors.so";
    if (!std::filesystem::exists(plugin)) GTEST_SKIP() << "built without mrpt-hwdrivers";
    if (!std::filesystem::exists("/usr/bin/rawlog-grabber"))
        GTEST_SKIP() << "rawlog-grabber is not installed";
    const TemporaryFolder folder;
    const std::string file = folder.write("corridor.ini", scenario);
    const std::string ini = folder.write(
        "grabber.ini", "[global]\nrawlog_prefix = " + (folder / "grabbed").string() +
                           "\ntime_between_launches = 0\nuse_sensoryframes = 0\nGRABBER_PERIOD_MS = 100\n"
                           "rawlog_GZ_compress_level = 1\n" +
                           section("wheels", file) + section("horizontal_laser", file));
    // It runs until its standard input says something.
    const auto grabbed =
        run_program({"/bin/sh", "-c", "sleep 4 | rawlog-grabber -p '" + plugin + "' '" + ini + "'"},
                    environment_of_our_plugins());
    std::string rawlog;
    for (const auto& entry : std::filesystem::directory_iterator(folder.path()))
        if (entry.path().extension() == ".rawlog") rawlog = entry.path().string();
    ASSERT_FALSE(rawlog.empty()) << grabbed.out << grabbed.err;
    const auto theirs = scans_of(rawlog);
    ASSERT_GT(theirs.size(), 20u) << grabbed.out << grabbed.err;

    const std::string own = (folder / "own.log").string();
    ASSERT_EQ(run_loopline({"simulate", file, "--out", own, "--set", "simulation.seed=3"}).exit_code, 0);
    const auto ours = scans_of(own);
    for (const auto& [stamp_ns, scan] : theirs) {
        const auto found = ours.find(stamp_ns);
        ASSERT_NE(found, ours.end());
        ASSERT_EQ(scan->sensorLabel, "horizontal_laser");
        for (std::size_t k = 0; k < scan->getScanSize(); ++k)
            ASSERT_EQ(scan->getScanRange(k), found->second->getScanRange(k));
    }
}
