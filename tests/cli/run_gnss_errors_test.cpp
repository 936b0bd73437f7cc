/// metrics.json says how far the receiver's own fixes are from a truth that lies on the Earth.
#include <gtest/gtest.h>

#include "gnss/geo_reference.h"
#include "gnss/gps_observation.h"
#include "run_support.h"

using namespace loopline;
using namespace loopline::testing;

TEST(RunGnssErrors, are_in_the_metrics) {
    const SmallRun small;
    auto objects = drive(20);
    const gnss::GeoReference frame({48, 11, 500}, 30);
    std::string truth;
    for (int i = 0; i < 20; ++i) {
        gnss::GnssFix fix;
        fix.stamp_ns = log_start_ns + i * second_ns / 10;
        fix.quality = i < 15 ? gnss::FixQuality::single : gnss::FixQuality::invalid;
        fix.has_position = fix.has_height = i < 15;
        fix.p_base_antenna_m = {1, 0, 2};
        fix.antenna = frame.geodetic({1.0 * i + 1 + 3, 4, 2 - 1.0});  // 3 m ahead, 4 m left, 1 m too low
        objects.push_back(gnss::gps_observation(fix, "receiver"));
        truth += seconds_text(fix.stamp_ns) + " " + std::to_string(i) + " 0 0 0 0 0 1\n";
    }
    const std::string log = small.folder() / "drive.rawlog";
    write_log(log, objects);
    write_file(small.folder() / "drive.truth.tum", truth);
    write_file(small.folder() / "drive.truth.csv", "georeference,0,48,11,500,30\n");
    const auto result = small.run(log);
    ASSERT_EQ(result.exit_code, 0) << result.err;
    const auto metrics = small.metrics();
    EXPECT_NEAR(metrics.at("gnss_horizontal_rmse_m").get<double>(), 5, 1e-5);
    EXPECT_NEAR(metrics.at("gnss_horizontal_max_m").get<double>(), 5, 1e-5);
    EXPECT_NEAR(metrics.at("gnss_vertical_rmse_m").get<double>(), 1, 1e-5);
    EXPECT_EQ(metrics.at("gnss_fixes_compared").get<int>(), 15);
}
