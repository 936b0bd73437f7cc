/// The column maps that come with the program, on their logs.
#include <gtest/gtest.h>
#include <mrpt/obs/CObservationGPS.h>
#include <mrpt/obs/CObservationIMU.h>
#include <mrpt/obs/CObservationOdometry.h>

#include <sstream>

#include "api/parameters.h"
#include "commands/imu_survey.h"
#include "evaluate/fix_errors.h"
#include "gnss/gps_observation.h"
#include "pipeline/log_source.h"
#include "support/built_files.h"
#include "support/run_program.h"
#include "support/shared_data.h"

using namespace loopline;

namespace {

/// A log imported into a temporary folder.
struct ImportedLog {
    ImportedLog(const std::string& log, const std::string& columns) {
        const auto result = test::run_loopline(
            {"import", "csv", (test::shared_data() / log).string(), "--columns", columns, "--out", path()});
        EXPECT_EQ(result.exit_code, 0) << result.err;
        said = result.out + result.err;
    }
    std::string path() const { return (folder / "log.rawlog").string(); }

    test::TemporaryFolder folder;
    std::string said;
};

/// What a check says of a log, on one line.
std::string checked(const std::string& ini, const std::string& rawlog) {
    std::istringstream words(test::run_loopline({"check", ini, "--rawlog", rawlog}).out);
    std::string text;
    for (std::string word; words >> word;) text += (text.empty() ? "" : " ") + word;
    return text;
}

std::string complaints_of_imus(const std::string& rawlog) {
    ImuSurvey survey;
    LogSource source({rawlog});
    StreamItem item;
    while (source.next(item)) survey.add(item);
    std::string text;
    for (const auto& sentence : survey.complaints(0)) text += sentence + "\n";
    return text;
}

}  // namespace

TEST(ColumnMaps, comma2k19_is_placed_on_the_earth_in_utc) {
    NEEDS_SHARED_DATA("comma2k19_example1/gnss_ublox.csv");
    const ImportedLog log("comma2k19_example1", "comma2k19");
    EXPECT_NE(
        log.said.find("4974 of steering, 4974 of wheels, 6256 of imu, 579 of ublox, 30 of qcom, 1200 true "
                      "poses, over 60"),
        std::string::npos)
        << log.said;
    EvaluationSettings settings;
    settings.truth = (log.folder / "log.truth.tum").string();
    settings.surveyed = (log.folder / "log.truth.csv").string();
    const auto reference = load_evaluation_reference(settings);
    const auto errors = FixErrors::against(reference);
    ASSERT_TRUE(errors);
    LogSource source({log.path()});
    std::map<std::string, Pose2> last;
    for (StreamItem item; source.next(item);) {
        if (const auto* gps = dynamic_cast<const mrpt::obs::CObservationGPS*>(item.observation.get()))
            errors->take(*gps, item.stamp_ns);
        if (const auto* wheels = dynamic_cast<const mrpt::obs::CObservationOdometry*>(item.observation.get()))
            last[wheels->sensorLabel] = {wheels->odometry.x(), wheels->odometry.y(), wheels->odometry.phi()};
    }
    const auto metrics = errors->metrics();
    const auto value = [&](const char* key) { return std::get<double>(metrics.at(key)); };
    // By a computation of its own, outside of this program: 1.1 m and 4.0 m before the latency is taken out.
    EXPECT_NEAR(value("gnss_ublox_horizontal_rmse_m"), 0.6, 0.2);
    EXPECT_NEAR(value("gnss_qcom_horizontal_rmse_m"), 4.0, 0.3);
    EXPECT_EQ(std::get<std::int64_t>(metrics.at("gnss_fixes_compared")), 579 + 30);
    for (const auto& [key, metric] : metrics)
        if (const auto* number = std::get_if<double>(&metric)) RecordProperty(key, number_text(*number));
    // The road is nearly straight and 1,012 m long.
    EXPECT_NEAR(last.at("steering").translation().norm(), 1012, 15);
    EXPECT_NEAR(last.at("wheels").translation().norm(), 1012, 25);
    EXPECT_EQ(complaints_of_imus(log.path()), "") << "turned over, as the map says";
}

TEST(ColumnMaps, husky_has_its_imu_upright_by_the_map_and_else_it_is_said_how_to_right_it) {
    NEEDS_SHARED_DATA("husky_robot_localization/husky_imu.csv");
    const ImportedLog log("husky_robot_localization", "husky");
    EXPECT_NE(log.said.find("3952 of wheels, 11865 of imu, 989 of gnss, over 395.4 s"), std::string::npos)
        << log.said;
    EXPECT_EQ(complaints_of_imus(log.path()),
              "CObservationIMU \"imu\" comes at 30 Hz, and inertial navigation wants 100 Hz or more; raise "
              "its output "
              "rate\n")
        << "neither its mount nor its stamps";
    LogSource turned({log.path()});
    ImuSurvey survey;
    for (StreamItem item; turned.next(item);) survey.add(item);
    ASSERT_EQ(survey.remarks().size(), 1U);
    EXPECT_EQ(
        survey.remarks()[0],
        "CObservationIMU \"imu\" is mounted turned, as the log has it: its +y axis points up, by gravity "
        "too (yaw_deg = -90, pitch_deg = 0, roll_deg = 90)");

    std::string unturned = test::file_text(test::source_folder() + "/datasets/columns/husky.ini");
    for (const std::string line : {"\nyaw_deg = -90\n", "\nroll_deg = 90\n"})
        unturned.replace(unturned.find(line), line.size(), "\n");
    const ImportedLog as_recorded("husky_robot_localization", log.folder.write("unturned.ini", unturned));
    // As a user sees it.
    const auto ini = log.folder.write("check.ini", "[run]\nmodules = odometry\n");
    const auto check = checked(ini, as_recorded.path());
    EXPECT_NE(check.find("CObservationIMU \"imu\" feels gravity along its +y axis"), std::string::npos)
        << check;
    EXPECT_NE(
        check.find("it is mounted turned, where the log has it upright; say so with [mount] sensors = imu, "
                   "yaw_deg = -90, pitch_deg = 0, roll_deg = 90"),
        std::string::npos)
        << check;
    const auto righted =
        checked(log.folder.write("mount.ini",
                                 "[run]\nmodules = odometry\n[mount]\nsensors = imu\nyaw_deg = -90\n"
                                 "pitch_deg = 0\nroll_deg = 90\n"),
                as_recorded.path());
    EXPECT_EQ(righted.find("where the log has it upright"), std::string::npos) << righted;
}

TEST(ColumnMaps, victoria_park_has_wheels_and_fixes_in_metres) {
    NEEDS_SHARED_DATA("victoria_park/gps.csv");
    const ImportedLog log("victoria_park", "victoria_park");
    EXPECT_NE(log.said.find("61945 of wheels, 4466 of gnss, 7230 of trunks, over 1549.6 s"),
              std::string::npos)
        << log.said;
    LogSource source({log.path()});
    double way_m = 0;
    std::optional<Pose2> last;
    Eigen::Vector2d least_m(1e9, 1e9), most_m = -least_m;
    const gnss::LocalFrame frame({-33.887, 151.192, 0});
    for (StreamItem item; source.next(item);) {
        if (const auto* wheels =
                dynamic_cast<const mrpt::obs::CObservationOdometry*>(item.observation.get())) {
            const Pose2 pose{wheels->odometry.x(), wheels->odometry.y(), wheels->odometry.phi()};
            if (last) way_m += (pose.translation() - last->translation()).norm();
            last = pose;
        }
        if (const auto* gps = dynamic_cast<const mrpt::obs::CObservationGPS*>(item.observation.get())) {
            auto place = gnss::fix_from_mrpt(*gps, item.stamp_ns)->antenna;
            EXPECT_EQ(gnss::fix_from_mrpt(*gps, item.stamp_ns)->has_height, false);
            const Eigen::Vector2d p_m = frame.p_enu_m(place).head<2>();
            least_m = least_m.cwiseMin(p_m);
            most_m = most_m.cwiseMax(p_m);
        }
    }
    // The sizes that the log's own description tells.
    EXPECT_NEAR(way_m, 4030, 100);
    EXPECT_NEAR(most_m.x() - least_m.x(), 309, 1);
    EXPECT_NEAR(most_m.y() - least_m.y(), 256, 1);
}
