/// What the survey of a log finds in made-up streams.
#include <gtest/gtest.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CObservationOdometry.h>

#include "commands/log_survey.h"
#include "support/second.h"

using namespace loopline;
using loopline::test::second_ns;

namespace {

StreamItem odometry_at(StampNs stamp_ns, const std::string& label = "odometry") {
    auto observation = mrpt::obs::CObservationOdometry::Create();
    observation->sensorLabel = label;
    return {0, stamp_ns, observation};
}

}  // namespace

TEST(LogSurvey, a_steady_sensor_draws_no_complaint) {
    LogSurvey survey;
    for (int i = 0; i < 50; ++i) survey.add(odometry_at(100 * second_ns + i * second_ns / 10));
    const auto& sensor = survey.sensors().at({"CObservationOdometry", "odometry"});
    EXPECT_EQ(sensor.count, 50u);
    EXPECT_EQ(sensor.median_step_ns(), second_ns / 10);
    EXPECT_EQ(sensor.longest_gap_ns, second_ns / 10);
    EXPECT_EQ(survey.latest_stamp_ns() - survey.earliest_stamp_ns(), 49 * second_ns / 10);
    EXPECT_TRUE(survey.complaints().empty());
}

TEST(LogSurvey, finds_the_pause_and_the_repeated_stamp_of_the_right_sensor) {
    LogSurvey survey;
    for (int i = 0; i < 20; ++i) {
        const StampNs pause_ns = i >= 10 ? 3 * second_ns : 0;
        survey.add(odometry_at(i * second_ns / 10 + pause_ns, "left"));
        survey.add(odometry_at(i * second_ns / 10, "right"));
    }
    survey.add(odometry_at(19 * second_ns / 10, "right"));
    const auto complaints = survey.complaints();
    ASSERT_EQ(complaints.size(), 2u);
    EXPECT_EQ(complaints[0],
              "CObservationOdometry \"left\" pauses for 3.100 s, from 0.900 s on; its usual step is 0.100 s");
    EXPECT_EQ(complaints[1],
              "CObservationOdometry \"right\" has 1 observations with the stamp of the one before");
}

TEST(LogSurvey, counts_scans_without_a_return) {
    LogSurvey survey;
    for (const float range_m : {1.F, 0.F, 2.F}) {
        auto scan = mrpt::obs::CObservation2DRangeScan::Create();
        const float ranges_m[] = {range_m, range_m};
        const char valid[] = {1, 1};
        scan->aperture = 1;
        scan->maxRange = 80;
        scan->loadFromVectors(2, ranges_m, valid);
        survey.add({0, StampNs(range_m * 1e8F), scan});
    }
    EXPECT_EQ(survey.sensors().begin()->second.empty_scans, 1u);
}

TEST(LogSurvey, writes_dates_and_seconds) {
    EXPECT_EQ(utc_text(1137834225973760000), "2006-01-21 09:03:45 UTC");
    EXPECT_EQ(seconds_since(1137834225973760000, 1137834226973860000), "1.000");
}
