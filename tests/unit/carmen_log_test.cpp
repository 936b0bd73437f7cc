/// CARMEN's messages word by word, damaged lines, and what is derived about the laser.
#include <gtest/gtest.h>
#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CActionRobotMovement2D.h>
#include <mrpt/obs/CSensoryFrame.h>

#include <sstream>

#include "importers/carmen_importer.h"
#include "importers/carmen_objects.h"
#include "support/run_program.h"

using namespace loopline;
using namespace loopline::carmen;

namespace {

Log log_of(const std::string& text) {
    std::istringstream stream(text);
    Log log;
    read_log(stream, "a.log", log);
    return log;
}

const Scan& scan_at(const Log& log, std::size_t i) {
    return std::get<Scan>(log.records.at(i));
}

std::string flaser(double x_m, double time_s, double laser_ahead_m = 0,
                   const std::string& ranges = "3 1.5 2 81.91") {
    std::ostringstream line;
    line << "FLASER " << ranges << ' ' << x_m + laser_ahead_m << " 0 0 " << x_m << " 0 0 " << std::fixed
         << time_s << " host " << time_s + 0.5 << '\n';
    return line.str();
}

/// Keeps copies of what an importer writes.
struct Kept : RawlogSink {
    void write(const mrpt::serialization::CSerializable& object) override {
        objects.push_back(
            std::dynamic_pointer_cast<mrpt::serialization::CSerializable>(object.duplicateGetSmartPtr()));
    }
    void warn(const std::string& sentence) override { warnings.push_back(sentence); }
    template <class Object>
    const Object& at(std::size_t i) const {
        return dynamic_cast<const Object&>(*objects.at(i));
    }
    std::vector<mrpt::serialization::CSerializable::Ptr> objects;
    std::vector<std::string> warnings;
};

struct Imported : Kept {
    std::string summary, error;
};

Imported import(const std::string& text,
                const std::vector<std::pair<std::string, std::string>>& settings = {}) {
    const loopline::test::TemporaryFolder folder;
    CarmenImporter importer;
    for (const auto& [key, value] : settings)
        EXPECT_FALSE(importer.parameters().find(key)->parse(value)) << key;
    Imported result;
    try {
        result.summary = importer.import({folder.write("a.log", text)}, result);
    } catch (const std::runtime_error& e) {
        result.error = e.what();
    }
    return result;
}

}  // namespace

TEST(CarmenLog, every_message_keeps_its_numbers_and_its_place) {
    const Log log = log_of(
        "# comment\n"
        "PARAM robot_frontlaser_offset 0.25 0 host 0\n"
        "ODOM 1 2 3.5 0.1 -0.2 0 976052857.337530 host 0.000246\n"
        "FLASER 3 1.07 nan 81.83 4 5 6 7 8 -4 976052857.348896 host 0.011612\r\n"
        "TRUEPOS 1 2 3\n"
        "ROBOTLASER1 0 -1.5 3 1.5 20.5 0.01 0 2 5 6 1 77 1 2 3 4 5 6 0.1 0.2 0.3 0.4 0 12.5 host 12.6\n"
        "RAWLASER1 0 -0.7 1.4 0.7 30 0.01 0 3 1 2 3 0 99.25 host 99.5\n");
    EXPECT_TRUE(log.damaged.empty());
    ASSERT_EQ(log.records.size(), 4u);
    EXPECT_EQ(log.parameters.at("robot_frontlaser_offset"), "0.25");
    EXPECT_EQ(log.skipped.at("TRUEPOS"), 1u);

    const auto& odometry = std::get<Odometry>(log.records[0]);
    EXPECT_EQ(odometry.times.ipc_ns, 976052857337530000);
    EXPECT_EQ(odometry.times.logger_ns, 246000);
    EXPECT_DOUBLE_EQ(odometry.turn_rate_radps, -0.2);
    EXPECT_DOUBLE_EQ(odometry.T_odom_base.phi_rad, wrap_to_pi(3.5));

    const Scan& flaser_scan = scan_at(log, 1);
    EXPECT_EQ(flaser_scan.ranges_m, (std::vector<float>{1.07F, 0, 81.83F}))
        << "what is no number is no return";
    EXPECT_DOUBLE_EQ(flaser_scan.T_odom_laser->x_m, 4);
    EXPECT_DOUBLE_EQ(flaser_scan.T_odom_base->x_m, 7);
    EXPECT_EQ(flaser_scan.times.ipc_ns, 976052857348896000);

    const Scan& robotlaser = scan_at(log, 2);
    EXPECT_EQ(robotlaser.message, Message::robotlaser);
    EXPECT_EQ(robotlaser.ranges_m, (std::vector<float>{5, 6}));
    EXPECT_DOUBLE_EQ(robotlaser.configuration->max_range_m, 20.5);
    EXPECT_DOUBLE_EQ(robotlaser.T_odom_laser->x_m, 1);
    EXPECT_DOUBLE_EQ(robotlaser.T_odom_base->y_m, 5);
    EXPECT_EQ(robotlaser.times.ipc_ns, 12500000000);

    const Scan& rawlaser = scan_at(log, 3);
    EXPECT_FALSE(rawlaser.T_odom_base);
    EXPECT_DOUBLE_EQ(rawlaser.configuration->start_angle_rad, -0.7);
    EXPECT_EQ(rawlaser.times.logger_ns, 99500000000);
}

TEST(CarmenLog, a_damaged_line_is_left_out_with_a_sentence) {
    const struct {
        const char *line, *expected;
    } cases[] = {
        {"FLASER 3 1 2", "a.log:2: this FLASER line ends before its range"},
        {"FLASER 3 1 2 x 0 0 0 0 0 0 1 host 1", "has a range that is no number"},
        {"FLASER -1 0 0 0 0 0 0 1 host 1", "has no sensible number of ranges"},
        {"FLASER 1e12 1 2", "has no sensible number of ranges"},
        {"FLASER 2.5 1 2 0 0 0 0 0 0 1 host 1", "has no sensible number of ranges"},
        {"FLASER 0 0 0 0 0 0 0 1 host 1", "has no ranges"},
        {"FLASER 1 5 0 0 inf 0 0 0 1 host 1", "has a laser pose that is not finite"},
        {"FLASER 1 5 0 0 0 0 0 0 soon host 1", "has a ipc time that is no time"},
        {"FLASER 1 5 0 0 0 0 0 0 1 host 1 7", "goes on behind its logger time"},
        {"ODOM 1 2", "this ODOM line ends before its pose"},
        {"RAWLASER1 0 -1 3 0 20 0 0 1 5 0 1 host 1", "has a resolution that is not above 0"},
    };
    for (const auto& c : cases) {
        const Log log = log_of(flaser(1, 1) + c.line + "\n" + flaser(2, 2));
        EXPECT_EQ(log.records.size(), 2u) << c.line;
        ASSERT_EQ(log.damaged.size(), 1u) << c.line;
        EXPECT_NE(log.damaged[0].find(c.expected), std::string::npos) << log.damaged[0];
        EXPECT_EQ(log.damaged[0].rfind("a.log:2: ", 0), 0u);
    }
}

TEST(CarmenLog, cut_anywhere_it_still_gives_all_whole_lines) {
    const std::string text = flaser(0, 1) + flaser(0.1, 2) + flaser(0.2, 3);
    for (std::size_t length = 0; length < text.size(); ++length) {
        const Log log = log_of(text.substr(0, length));
        EXPECT_GE(log.records.size(),
                  static_cast<std::size_t>(
                      std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(length), '\n')));
        EXPECT_LE(log.damaged.size(), 1u);
    }
}

TEST(CarmenGeometry, the_laser_sits_where_the_poses_or_else_the_parameter_say) {
    // Laser 0.3 m ahead and 0.1 m to the left, turned by 0.2 rad, on a robot that turns.
    const Pose2 T_base_laser{0.3, 0.1, 0.2};
    std::string text;
    for (int i = 0; i < 20; ++i) {
        const Pose2 base{0.1 * i, 0.02 * i, 0.3 * i};
        const Pose2 laser = base * T_base_laser;
        char line[300];
        std::snprintf(line, sizeof line, "FLASER 1 5 %f %f %f %f %f %f %d host %d\n", laser.x_m, laser.y_m,
                      laser.phi_rad, base.x_m, base.y_m, base.phi_rad, i, i);
        text += line;
    }
    const Mounting from_poses = find_mounting(log_of(text), Message::flaser);
    EXPECT_EQ(from_poses.source, Mounting::Source::poses);
    EXPECT_NEAR(from_poses.T_base_laser.x_m, 0.3, 1e-5);
    EXPECT_NEAR(from_poses.T_base_laser.phi_rad, 0.2, 1e-5);

    const std::string same = flaser(0, 1) + flaser(1, 2);
    EXPECT_EQ(find_mounting(log_of(same), Message::flaser).source, Mounting::Source::unknown);
    const Mounting parameter =
        find_mounting(log_of("PARAM robot_frontlaser_offset 0.25 0 h 0\n" + same), Message::flaser);
    EXPECT_EQ(parameter.source, Mounting::Source::parameter);
    EXPECT_DOUBLE_EQ(parameter.T_base_laser.x_m, 0.25);

    const Mounting corrected = find_mounting(log_of(flaser(0, 1, 0.1) + flaser(1, 2, 0.7)), Message::flaser);
    EXPECT_TRUE(corrected.corrected_poses);
    EXPECT_EQ(corrected.source, Mounting::Source::unknown);
}

TEST(CarmenImporter, frames_keep_order_stamps_odometry_and_validity) {
    const std::string damaged = "FLASER 4 1\n";
    const Imported log = import(flaser(1, 100) + damaged + flaser(1.5, 99.5) + flaser(3, 101),
                                {{"aperture_deg", "90"}, {"max_range_m", "80"}});
    ASSERT_EQ(log.error, "");
    ASSERT_EQ(log.objects.size(), 6u);
    ASSERT_EQ(log.warnings.size(), 1u);
    EXPECT_NE(log.warnings[0].find("a.log:2:"), std::string::npos);
    EXPECT_NE(log.summary.find("the stamps go back 1 times, the file's order is kept"), std::string::npos)
        << log.summary;
    const double increments_m[] = {0, 0.5, 1.5}, stamps_s[] = {100, 99.5, 101};
    for (std::size_t i = 0; i < 3; ++i) {
        const auto* movement = log.at<mrpt::obs::CActionCollection>(2 * i)
                                   .getActionByClass<mrpt::obs::CActionRobotMovement2D>()
                                   .get();
        ASSERT_NE(movement, nullptr);
        EXPECT_DOUBLE_EQ(movement->rawOdometryIncrementReading.x(), increments_m[i]);
        const auto scan = log.at<mrpt::obs::CSensoryFrame>(2 * i + 1)
                              .getObservationByClass<mrpt::obs::CObservation2DRangeScan>();
        ASSERT_NE(scan, nullptr);
        EXPECT_EQ(stamp_from_mrpt(scan->timestamp), static_cast<StampNs>(stamps_s[i] * 1e9));
        EXPECT_EQ(stamp_from_mrpt(movement->timestamp), stamp_from_mrpt(scan->timestamp));
        ASSERT_EQ(scan->getScanSize(), 3u);
        EXPECT_FLOAT_EQ(scan->getScanRange(1), 2);
        EXPECT_TRUE(scan->getScanRangeValidity(1));
        EXPECT_FALSE(scan->getScanRangeValidity(2)) << "81.91 is the sensor's word for nothing";
        EXPECT_FLOAT_EQ(scan->aperture, static_cast<float>(M_PI / 2));
    }
}

TEST(CarmenImporter, observations_take_the_odom_lines_or_else_the_scans_own_poses) {
    const std::string odom = "ODOM 0.7 0 0 0.3 0.1 0 99 host 99\n";
    const auto with = import(odom + flaser(1, 100),
                             {{"format", "observations"}, {"aperture_deg", "90"}, {"stamp", "logger"}});
    ASSERT_EQ(with.objects.size(), 2u) << with.error;
    EXPECT_DOUBLE_EQ(with.at<mrpt::obs::CObservationOdometry>(0).odometry.x(), 0.7);
    EXPECT_DOUBLE_EQ(with.at<mrpt::obs::CObservationOdometry>(0).velocityLocal.vx, 0.3);
    EXPECT_EQ(stamp_from_mrpt(with.at<mrpt::obs::CObservation2DRangeScan>(1).timestamp), 100500000000)
        << "the logger's time";

    const auto without = import(flaser(1, 100), {{"format", "observations"}, {"aperture_deg", "90"}});
    ASSERT_EQ(without.objects.size(), 2u);
    EXPECT_DOUBLE_EQ(without.at<mrpt::obs::CObservationOdometry>(0).odometry.x(), 1);
    EXPECT_EQ(without.at<mrpt::obs::CObservationOdometry>(0).timestamp,
              without.at<mrpt::obs::CObservation2DRangeScan>(1).timestamp);
}

TEST(CarmenImporter, the_sensor_turns_when_its_beams_do_not_begin_symmetrically) {
    // Beams at -90, -45, 0 and 45 degrees: in the middle of them is -22.5 degrees.
    const auto log = import(
        "ROBOTLASER1 0 -1.570796 3.14 0.785398 20 0.01 0 4 5 6 7 8 0 1.2 2 0.1 1 2 0.1 0 0 0 0 0 12.5 h "
        "12.6\n");
    ASSERT_EQ(log.objects.size(), 2u) << log.error;
    const auto scan =
        log.at<mrpt::obs::CSensoryFrame>(1).getObservationByClass<mrpt::obs::CObservation2DRangeScan>();
    EXPECT_NEAR(scan->aperture, 3 * M_PI / 4, 1e-5);
    EXPECT_NEAR(scan->sensorPose.yaw(), -M_PI / 8, 1e-5);
    EXPECT_NEAR(scan->sensorPose.x(), 0.2 * std::cos(0.1), 1e-5);
    EXPECT_FLOAT_EQ(scan->maxRange, 20);
}

TEST(CarmenImporter, what_cannot_be_imported_is_said_in_one_sentence) {
    EXPECT_NE(import("").error.find("is empty"), std::string::npos);
    EXPECT_NE(import("ODOM 0 0 0 0 0 0 1 h 1\n").error.find("there is no laser scan"), std::string::npos);
    EXPECT_NE(import(std::string("\0\1\2junk\n\xff\xfe", 10)).error.find("there is no laser scan"),
              std::string::npos);
    EXPECT_NE(import(flaser(0, 1)).error.find("a scan has 3 beams"), std::string::npos);
    EXPECT_NE(import("RAWLASER1 0 -0.7 1.4 0.7 30 0.01 0 3 1 2 3 0 99.25 h 99.5\n")
                  .error.find("--format observations"),
              std::string::npos);
    EXPECT_EQ(import("PARAM laser_front_laser_resolution 1.0 0 h 0\n" + flaser(0, 1)).error, "");
}

TEST(CarmenImporter, scans_that_other_messages_repeat_come_once) {
    const auto log = import("RAWLASER1 0 -0.7 1.4 0.7 30 0.01 0 3 1 2 3 0 1 h 1\n" + flaser(0, 1),
                            {{"aperture_deg", "90"}});
    EXPECT_EQ(log.objects.size(), 2u);
    ASSERT_EQ(log.warnings.size(), 1u);
    EXPECT_NE(log.warnings[0].find("1 RAWLASER1 lines repeat the FLASER lines"), std::string::npos);
}
