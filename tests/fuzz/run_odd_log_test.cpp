/// Logs that are intact but odd: the run says so and goes on, or says why it can't.
#include <gtest/gtest.h>
#include <mrpt/obs/CObservationOdometry.h>

#include <limits>

#include "cli/run_support.h"

using namespace loopline;
using namespace loopline::testing;

namespace {

void expect_warning(const test::ProgramResult& result, const std::string& words) {
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_NE(result.err.find(words), std::string::npos) << result.err;
    EXPECT_NE(result.err.find("warning: "), std::string::npos) << result.err;
}

}  // namespace

TEST(RunOddLog, without_scans_says_what_there_is_and_writes_nothing) {
    const SmallRun small;
    const std::string log = small.folder() / "talk.rawlog";
    auto odometry = mrpt::obs::CObservationOdometry::Create();
    odometry->sensorLabel = "ODO";
    write_log(log, {odometry});
    const auto result = small.run(log);
    EXPECT_EQ(result.exit_code, 3);
    EXPECT_NE(
        result.err.find("needs CObservation2DRangeScan, and this log holds 1 CObservationOdometry (ODO)"),
        std::string::npos)
        << result.err;
    expect_sentences(result.err, log);
    EXPECT_FALSE(std::filesystem::exists(small.out()));
}

TEST(RunOddLog, NaN_and_zero_ranges_are_no_obstacle) {
    const SmallRun small("odometry lines");
    const std::string log = small.folder() / "spotted.rawlog";
    std::vector<mrpt::serialization::CSerializable::Ptr> objects;
    for (int i = 0; i < 20; ++i) {
        append_step(objects, i);
        auto spotted = scan(log_start_ns + i * second_ns / 10 + 1000, "SPOTTED", 181);
        for (std::size_t beam = 0; beam < 181; ++beam)
            if (beam % 3 == 0)
                spotted->setScanRange(beam, std::numeric_limits<float>::quiet_NaN());
            else if (beam % 3 == 1 || i % 2 == 0)
                spotted->setScanRange(beam, 0);
        objects.push_back(frame({spotted}));
    }
    write_log(log, objects);
    const auto result = small.run(log);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_EQ(small.metrics()["scans_read"], 40);
    EXPECT_EQ(small.text_of("trajectory.tum").find("nan"), std::string::npos);
}

TEST(RunOddLog, impossible_observations_are_left_out_and_counted) {
    const SmallRun small;
    const std::string log = small.folder() / "wild.rawlog";
    auto objects = drive(10);
    auto wild = scan(log_start_ns + second_ns);
    wild->aperture = std::numeric_limits<float>::infinity();
    objects.push_back(frame({wild}));
    write_log(log, objects);
    expect_warning(small.run(log), "left out 1 laser scans whose aperture is not within 0 .. 360 deg");
    EXPECT_EQ(small.metrics()["observations_refused"], 1);
    EXPECT_EQ(small.metrics()["scans_read"], 10);
}

TEST(RunOddLog, time_that_goes_backwards_is_told_and_the_order_kept) {
    const SmallRun small;
    const std::string log = small.folder() / "back.rawlog";
    auto objects = drive(10);
    std::swap(objects[6], objects[8]);  // two frames
    write_log(log, objects);
    expect_warning(small.run(log), "stamps go backwards 1 time, by 0.100 s");
    EXPECT_EQ(small.rows_of_trajectory(), 10u);
}

TEST(RunOddLog, two_sensors_with_one_label_are_told) {
    const SmallRun small;
    const std::string log = small.folder() / "twins.rawlog";
    std::vector<mrpt::serialization::CSerializable::Ptr> objects;
    for (int i = 0; i < 10; ++i) append_step(objects, i, i % 2 == 0 ? 181 : 361);
    write_log(log, objects);
    expect_warning(small.run(log), "two laser scanners seem to share the label \"LASER\"");
}

TEST(RunOddLog, scans_without_a_stamp_are_told) {
    const SmallRun small;
    const std::string log = small.folder() / "timeless.rawlog";
    auto objects = drive(4);
    objects.push_back(move(0.1, 0, 0));
    objects.push_back(frame({scan(0, "LASER", 181)}));
    write_log(log, objects);
    expect_warning(small.run(log), "observations have no stamp");
}
