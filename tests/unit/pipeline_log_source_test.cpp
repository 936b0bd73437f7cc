/// The log as a stream: odometry from actions, stamps, merging, and what is kept out.
#include <gtest/gtest.h>
#include <mrpt/obs/CObservationComment.h>
#include <mrpt/obs/CObservationGPS.h>
#include <mrpt/obs/CObservationIMU.h>
#include <mrpt/obs/CObservationOdometry.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "commands/command.h"
#include "pipeline/log_source.h"
#include "pipeline/raw_value.h"
#include "pipeline_logs.h"

using namespace loopline;
using namespace loopline::testing;
using mrpt::obs::CObservation2DRangeScan;
using mrpt::obs::CObservationOdometry;

namespace {

constexpr StampNs s = 1'000'000'000;
constexpr StampNs start_ns = 1'600'000'000 * s;
const double nan_value = std::numeric_limits<double>::quiet_NaN();

std::vector<StreamItem> stream(LogSource& source) {
    std::vector<StreamItem> items;
    for (StreamItem item; source.next(item);) items.push_back(item);
    return items;
}

std::vector<StreamItem> stream(const std::string& path) {
    LogSource source({path});
    return stream(source);
}

const CObservationOdometry* odometry_of(const StreamItem& item) {
    return dynamic_cast<const CObservationOdometry*>(item.observation.get());
}

bool mentions(const std::vector<std::string>& sentences, const std::string& words) {
    for (const auto& sentence : sentences)
        if (sentence.find(words) != std::string::npos) return true;
    return false;
}

mrpt::obs::CObservationOdometry::Ptr odometry_reading(StampNs stamp_ns, double x_m) {
    auto odometry = CObservationOdometry::Create();
    odometry->timestamp = stamp_to_mrpt(stamp_ns);
    odometry->sensorLabel = "ODO";
    odometry->odometry = {x_m, 0, 0};
    return odometry;
}

}  // namespace

TEST(LogSource, actions_become_cumulative_odometry_just_before_their_frame) {
    Folder folder;
    write_log(folder / "log",
              {move(9, 9, 1), frame({scan(start_ns)}),  // before the first frame: nothing to move
               move(1, 0, M_PI / 2), frame({scan(start_ns + s), scan(start_ns + s + 1000, "REAR")}),
               move(2, 0, 0), move(1, 0, -M_PI / 2), frame({scan(start_ns + 2 * s)})});
    const auto items = stream(folder / "log");
    ASSERT_EQ(items.size(), 7u);
    const std::vector<std::size_t> odometry_at = {0, 2, 5};
    const std::vector<Pose2> expected = {{0, 0, 0}, {1, 0, M_PI / 2}, {1, 3, 0}};
    for (std::size_t i = 0; i < odometry_at.size(); ++i) {
        const auto* odometry = odometry_of(items[odometry_at[i]]);
        ASSERT_NE(odometry, nullptr) << i;
        EXPECT_NEAR(odometry->odometry.x(), expected[i].x_m, 1e-9);
        EXPECT_NEAR(odometry->odometry.y(), expected[i].y_m, 1e-9);
        EXPECT_NEAR(wrap_to_pi(odometry->odometry.phi() - expected[i].phi_rad), 0, 1e-9);
        EXPECT_EQ(odometry->sensorLabel, "odometry");
        EXPECT_EQ(items[odometry_at[i]].stamp_ns, start_ns + static_cast<StampNs>(i) * s);
    }
    for (std::size_t i = 0; i < items.size(); ++i) EXPECT_EQ(items[i].sequence, i);
}

TEST(LogSource, a_log_that_begins_with_a_frame_gets_the_origin_there) {
    Folder folder;
    write_log(folder / "log", {frame({scan(start_ns)}), move(1, 0, 0), frame({scan(start_ns + s)})});
    const auto items = stream(folder / "log");
    ASSERT_EQ(items.size(), 4u);
    ASSERT_NE(odometry_of(items[0]), nullptr);
    EXPECT_EQ(odometry_of(items[0])->odometry.x(), 0);
    EXPECT_NEAR(odometry_of(items[2])->odometry.x(), 1, 1e-9);

    write_log(folder / "bare", {frame({scan(start_ns)}), frame({scan(start_ns + s)})});
    EXPECT_EQ(stream(folder / "bare").size(), 2u) << "no odometry in the log, none invented";
}

TEST(LogSource, ticks_add_up_and_velocities_are_carried) {
    Folder folder;
    const auto with_ticks = [](int left, int right, double vx) {
        mrpt::obs::CActionRobotMovement2D action;
        action.computeFromOdometry({0.1, 0, 0}, {});
        action.hasEncodersInfo = action.hasVelocities = true;
        action.encoderLeftTicks = left;
        action.encoderRightTicks = right;
        action.velocityLocal = {vx, 0, 0.5};
        auto actions = mrpt::obs::CActionCollection::Create();
        actions->insert(action);
        return actions;
    };
    write_log(folder / "log", {frame({scan(start_ns)}), with_ticks(10, 12, 1), frame({scan(start_ns + s)}),
                               with_ticks(-3, 5, nan_value), frame({scan(start_ns + 2 * s)})});
    const auto items = stream(folder / "log");
    ASSERT_EQ(items.size(), 6u);
    EXPECT_EQ(odometry_of(items[2])->encoderRightTicks, 12);
    EXPECT_TRUE(odometry_of(items[2])->hasVelocities);
    EXPECT_DOUBLE_EQ(odometry_of(items[2])->velocityLocal.vx, 1);
    EXPECT_EQ(odometry_of(items[4])->encoderLeftTicks, 7);
    EXPECT_EQ(odometry_of(items[4])->encoderRightTicks, 17);
    EXPECT_FALSE(odometry_of(items[4])->hasVelocities) << "not a number";
}

TEST(LogSource, the_real_log_gives_the_odometry_that_MRPT_sums) {
    const auto items = stream(telecom_log);
    std::size_t scans = 0;
    const CObservationOdometry* last = nullptr;
    for (const auto& item : items) {
        if (const auto* odometry = odometry_of(item)) last = odometry;
        if (is_laser_scan(*item.observation)) ++scans;
    }
    EXPECT_EQ(scans, 225u);
    ASSERT_NE(last, nullptr);
    EXPECT_NEAR(last->odometry.x(), -4.80, 0.01);
    EXPECT_NEAR(last->odometry.y(), -21.16, 0.01);
    EXPECT_NEAR(last->odometry.phi(), -1.862, 0.001);
}

TEST(LogSource, stamps_that_go_backwards_are_reported_and_not_sorted) {
    Folder folder;
    write_log(folder / "log", {scan(start_ns), scan(start_ns + 5 * s), scan(start_ns + 2 * s),
                               scan(start_ns + 6 * s), scan(start_ns + 5 * s)});
    LogSource source({folder / "log"});
    const auto items = stream(source);
    ASSERT_EQ(items.size(), 5u);
    EXPECT_EQ(items[2].stamp_ns, start_ns + 2 * s);
    EXPECT_TRUE(mentions(source.warnings(), "stamps go backwards 2 times, by up to 3.000 s"));
}

TEST(LogSource, a_fix_that_comes_late_is_in_its_order) {
    Folder folder;
    const auto fix = [](StampNs stamp_ns, StampNs received_ns) {
        auto observation = mrpt::obs::CObservationGPS::Create();
        observation->timestamp = stamp_to_mrpt(stamp_ns);
        if (received_ns > 0) observation->originalReceivedTimestamp = stamp_to_mrpt(received_ns);
        return observation;
    };
    write_log(folder / "late",
              {scan(start_ns), scan(start_ns + 5 * s), fix(start_ns + 4 * s, start_ns + 5 * s),
               fix(start_ns + 4 * s + s / 2, start_ns + 6 * s), scan(start_ns + 6 * s)});
    LogSource late({folder / "late"});
    const auto items = stream(late);
    ASSERT_EQ(items.size(), 5u);
    EXPECT_EQ(items[2].stamp_ns, start_ns + 4 * s);
    EXPECT_FALSE(mentions(late.warnings(), "backwards"));
    // Not where it came, or nobody knows when; and what comes after a late one is compared with what came
    // before it.
    write_log(folder / "log",
              {scan(start_ns), scan(start_ns + 5 * s), fix(start_ns + 3 * s, start_ns + 4 * s),
               scan(start_ns + 6 * s), fix(start_ns + 5 * s, 0), scan(start_ns + 7 * s),
               fix(start_ns + 4 * s, start_ns + 8 * s), scan(start_ns + 5 * s)});
    LogSource source({folder / "log"});
    stream(source);
    EXPECT_TRUE(mentions(source.warnings(), "stamps go backwards 3 times, by up to 2.000 s"));
}

TEST(LogSource, a_missing_stamp_is_the_one_before) {
    Folder folder;
    write_log(folder / "log", {scan(start_ns), scan(0), scan(start_ns + s)});
    LogSource source({folder / "log"});
    const auto items = stream(source);
    ASSERT_EQ(items.size(), 3u);
    EXPECT_EQ(items[1].stamp_ns, start_ns);
    EXPECT_EQ(stamp_from_mrpt(items[1].observation->timestamp), start_ns);
    EXPECT_TRUE(mentions(source.warnings(), "1 observations have no stamp"));
}

TEST(LogSource, several_logs_are_merged_by_stamp_each_in_its_own_order) {
    Folder folder;
    write_log(folder / "a", {scan(start_ns, "a"), scan(start_ns + 4 * s, "a"), scan(start_ns + 1 * s, "a"),
                             scan(start_ns + 6 * s, "a")});
    write_log(folder / "b", {scan(start_ns, "b"), scan(start_ns + 3 * s, "b"), scan(start_ns + 5 * s, "b")});
    LogSource source({folder / "a", folder / "b"});
    std::string order;
    std::uint64_t sequence = 0;
    for (StreamItem item; source.next(item);) {
        order += item.observation->sensorLabel;
        EXPECT_EQ(item.sequence, sequence++);
    }
    EXPECT_EQ(order, "abbaaba")
        << "equal stamps: the file named first; a's third scan stays behind its second";
}

TEST(LogSource, impossible_numbers_are_kept_out_and_counted) {
    Folder folder;
    auto no_aperture = scan(start_ns), wild_pose = scan(start_ns), endless = scan(start_ns),
         spotted = scan(start_ns);
    no_aperture->aperture = static_cast<float>(nan_value);
    wild_pose->sensorPose.x(std::numeric_limits<double>::infinity());
    endless->maxRange = -1;
    spotted->setScanRange(1, static_cast<float>(nan_value));
    spotted->setScanRange(2, -3);
    spotted->setScanRange(3, std::numeric_limits<float>::infinity());
    auto imu = mrpt::obs::CObservationIMU::Create();
    imu->timestamp = stamp_to_mrpt(start_ns);
    imu->set(mrpt::obs::IMU_YAW_VEL, nan_value);
    write_log(folder / "log", {no_aperture, wild_pose, endless, scan(start_ns, "LASER", 1), imu,
                               odometry_reading(start_ns, 1e300), spotted});
    LogSource source({folder / "log"});
    const auto items = stream(source);
    ASSERT_EQ(items.size(), 1u);
    EXPECT_EQ(items[0].sequence, 0u);
    EXPECT_EQ(source.refused(), 6u);
    EXPECT_EQ(source.refusals().size(), 6u) << "each for its own reason";
    const auto& kept = dynamic_cast<const CObservation2DRangeScan&>(*items[0].observation);
    EXPECT_TRUE(kept.getScanRangeValidity(0));
    for (const std::size_t beam : {1, 2, 3}) EXPECT_FALSE(kept.getScanRangeValidity(beam)) << beam;
}

TEST(LogSource, impossible_increments_leave_the_odometry_where_it_was) {
    Folder folder;
    const auto broken = [](double x_m) {
        auto actions = move(0, 0, 0);
        dynamic_cast<mrpt::obs::CActionRobotMovement2D&>(*actions->get(0)).rawOdometryIncrementReading = {
            x_m, 0, 0};
        return actions;
    };
    write_log(folder / "log",
              {frame({scan(start_ns)}), move(1, 0, 0), frame({scan(start_ns + s)}), broken(1e9),
               frame({scan(start_ns + 2 * s)}), move(1, 0, 0), frame({scan(start_ns + 3 * s)})});
    LogSource source({folder / "log"});
    const auto items = stream(source);
    ASSERT_EQ(items.size(), 8u);
    EXPECT_NEAR(odometry_of(items[4])->odometry.x(), 1, 1e-9);
    EXPECT_NEAR(odometry_of(items[6])->odometry.x(), 2, 1e-9);
    EXPECT_EQ(source.refused(), 1u);
    EXPECT_TRUE(mentions(source.warnings(), "odometry increments"));
}

TEST(LogSource, the_ini_knows_better_where_a_sensor_sits) {
    Folder folder;
    auto front = CObservation2DRangeScan::Create(), rear = CObservation2DRangeScan::Create();
    for (const auto& [scan, label] : {std::pair(front, "front"), std::pair(rear, "rear")}) {
        scan->sensorLabel = label;
        scan->timestamp = stamp_to_mrpt(start_ns);
        scan->sensorPose = {0.5, 0, 0, 0, 0, 0};
        scan->aperture = 3;
        scan->resizeScanAndAssign(10, 1, true);
    }
    write_log(folder / "log", {front, rear});
    MountSettings mount;
    mount.sensors = {"rear"};
    mount.x_m = -0.2;
    mount.yaw_rad = M_PI / 2;
    mount.range_scale = 1.05;
    mount.range_offset_m = 0.03;
    mount.aperture_rad = 2.5;
    LogSource source({folder / "log"}, {}, Mounting(mount));
    const auto items = stream(source);
    ASSERT_EQ(items.size(), 2u);
    const auto pose = [&](std::size_t i) {
        return dynamic_cast<const CObservation2DRangeScan&>(*items[i].observation).sensorPose;
    };
    EXPECT_DOUBLE_EQ(pose(0).x(), 0.5);
    EXPECT_DOUBLE_EQ(pose(1).x(), -0.2);
    EXPECT_DOUBLE_EQ(pose(1).yaw(), M_PI / 2);
    const auto range_m = [&](std::size_t i) {
        return dynamic_cast<const CObservation2DRangeScan&>(*items[i].observation).getScanRange(3);
    };
    EXPECT_FLOAT_EQ(range_m(0), 1.0f);
    EXPECT_FLOAT_EQ(range_m(1), 1.08f);
    const auto aperture_rad = [&](std::size_t i) {
        return dynamic_cast<const CObservation2DRangeScan&>(*items[i].observation).aperture;
    };
    EXPECT_FLOAT_EQ(aperture_rad(0), 3.0f);
    EXPECT_FLOAT_EQ(aperture_rad(1), 2.5f);
}

TEST(LogSource, two_sensors_with_one_label_are_noticed) {
    Folder folder;
    auto rear = scan(start_ns + 3);
    rear->sensorPose.setFromValues(-0.5, 0, 0, M_PI);
    const std::vector<std::vector<mrpt::serialization::CSerializable::Ptr>> confused = {
        {scan(start_ns), odometry_reading(start_ns + 1, 0)},  // replaced below by one label
        {scan(start_ns, "LASER", 5), scan(start_ns + 1, "LASER", 7)},
        {scan(start_ns), rear},
    };
    std::dynamic_pointer_cast<CObservationOdometry>(confused[0][1])->sensorLabel = "LASER";
    for (const auto& objects : confused) {
        write_log(folder / "log", objects);
        LogSource source({folder / "log"});
        stream(source);
        EXPECT_TRUE(mentions(source.warnings(), "share the label \"LASER\""));
    }
    write_log(folder / "log", {scan(start_ns, "A", 5), scan(start_ns, "B", 7), scan(start_ns, "A", 5)});
    LogSource source({folder / "log"});
    stream(source);
    EXPECT_TRUE(source.warnings().empty());
}

TEST(LogSource, says_what_the_log_holds) {
    Folder folder;
    write_log(folder / "log",
              {scan(start_ns, "FRONT"), odometry_reading(start_ns, 0), scan(start_ns + s, "FRONT")});
    LogSource source({folder / "log"});
    stream(source);
    EXPECT_EQ(source.facts().inventory(), "2 CObservation2DRangeScan (FRONT), 1 CObservationOdometry (ODO)");
    EXPECT_TRUE(source.facts().has_class("CObservation2DRangeScan"));
    EXPECT_TRUE(source.facts().has_class("mrpt::obs::CObservationOdometry"));
    EXPECT_FALSE(source.facts().has_class("CObservationIMU"));
    EXPECT_EQ(source.facts().scans(), 2u);
    EXPECT_DOUBLE_EQ(source.fraction_read(), 1);
}

TEST(LogSource, damage_at_the_end_changes_nothing_before_it) {
    Folder folder;
    const auto whole = file_bytes(telecom_log);
    const auto intact = stream(telecom_log);
    for (const std::size_t size : {std::size_t{5000}, whole.size() / 2, whole.size() - 9}) {
        write_file(folder / "cut", whole.substr(0, size));
        LogSource source({folder / "cut"});
        const auto items = stream(source);
        EXPECT_EQ(source.damages().size(), 1u);
        ASSERT_LE(items.size(), intact.size());
        for (std::size_t i = 0; i < items.size(); ++i) {
            EXPECT_EQ(items[i].sequence, intact[i].sequence);
            EXPECT_EQ(items[i].stamp_ns, intact[i].stamp_ns);
        }
    }
}

TEST(LogSource, a_missing_log_is_refused_before_anything_is_read) {
    EXPECT_THROW(LogSource({telecom_log, "/nowhere.rawlog"}), CommandError);
}

TEST(RawValue, a_flag_with_a_damaged_byte_is_true) {
    unsigned char byte = 169;  // seen in a mutant of the real log
    bool flag = false;
    std::memcpy(&flag, &byte, sizeof(flag));
    EXPECT_TRUE(is_set(flag));
    settle(flag);
    std::memcpy(&byte, &flag, sizeof(flag));
    EXPECT_EQ(byte, 1);
}
