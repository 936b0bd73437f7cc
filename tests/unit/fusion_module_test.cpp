/// Module "fusion" as the host sees it.
#include "fusion/fusion_module.h"

#include <gtest/gtest.h>
#include <mrpt/obs/CObservationOdometry.h>

#include <cmath>
#include <limits>

#include "gnss/gps_observation.h"

using namespace loopline;

namespace {

class Unheard : public Publisher {
 public:
    void publish(const mrpt::obs::CObservation::Ptr&) override {}
    void publish(const mrpt::obs::CObservation::Ptr&, std::uint64_t) override {}
};

StreamItem pose_at(int second, double x_m) {
    const StampNs stamp_ns = 1'000'000'000LL * second;
    return {static_cast<std::uint64_t>(second), stamp_ns,
            pose_observation("lidar_mapping", stamp_to_mrpt(stamp_ns), Pose3(Pose2{x_m, 0, 0}),
                             Matrix6d::Identity() * 1e-6)};
}

TEST(FusionModule, a_pose_that_is_no_number_is_left_out_and_counted) {
    FusionModule module;
    module.start({});
    Unheard publisher;
    module.process(pose_at(1, 0), publisher);
    module.process(pose_at(2, std::numeric_limits<double>::quiet_NaN()), publisher);
    module.process(pose_at(3, 2), publisher);
    module.process(pose_at(2, 1), publisher);
    Results results;
    module.finish(results);
    EXPECT_EQ(std::get<std::int64_t>(results.metrics.at("poses_not_finite")), 1);
    EXPECT_EQ(std::get<std::int64_t>(results.metrics.at("poses_backward")), 1);
    ASSERT_EQ(module.trajectory()->size(), 2U);
    EXPECT_NEAR((*module.trajectory())[1].T_map_base.translation_m.x(), 2, 1e-9);
}

/// Warnings after three minutes whose fixes, of 5 Hz, are stamped so much later than they are of.
std::vector<std::string> warnings_of_late_fixes(double late_s, const std::string& latency_s) {
    FusionModule module;
    const ParameterTable table = module.parameters();
    for (const auto& parameter : table.parameters())
        if (parameter.name == "latency_s") {
            EXPECT_FALSE(parameter.parse(latency_s));
        }
    module.start({});
    Unheard publisher;
    const gnss::LocalFrame earth({50, 8, 200});
    Pose2 T{0, 0, 0.3};
    std::uint64_t sequence = 0;
    for (int k = 0; k < 1800; ++k) {
        const double t = 0.1 * k;
        const StampNs stamp_ns = 1'000'000'000'000LL + 100'000'000LL * k;
        module.process({sequence++, stamp_ns,
                        pose_observation("lidar_mapping", stamp_to_mrpt(stamp_ns), Pose3(T),
                                         Matrix6d::Identity() * 1e-6)},
                       publisher);
        if (k % 2 == 0) {
            gnss::GnssFix fix;
            fix.stamp_ns = stamp_ns + std::llround(1e9 * late_s);
            fix.quality = gnss::FixQuality::rtk_fixed;
            fix.has_position = fix.has_height = true;
            fix.antenna = earth.geodetic({T.x_m, T.y_m, 0});
            module.process({sequence++, fix.stamp_ns, gnss::gps_observation(fix, "gnss")}, publisher);
        }
        T = T * Pose2{0.1 * (7 + 5 * std::sin(t / 6)), 0, 0.025 * std::sin(t / 9)};
    }
    Results results;
    module.finish(results);
    return results.warnings;
}

TEST(FusionModule, says_so_where_fixes_are_stamped_late) {
    const auto warnings = warnings_of_late_fixes(0.4, "0");
    ASSERT_FALSE(warnings.empty());
    EXPECT_NE(warnings[0].find("are 0.40 s late"), std::string::npos) << warnings[0];
    EXPECT_NE(warnings[0].find("set [fusion] latency_s = 0.40"), std::string::npos) << warnings[0];
    EXPECT_TRUE(warnings_of_late_fixes(0.4, "0.4").empty());
    EXPECT_TRUE(warnings_of_late_fixes(0, "0").empty());
}

TEST(FusionModule, says_so_where_nothing_has_the_label_that_was_asked_for) {
    FusionModule module;
    const ParameterTable table = module.parameters();
    for (const auto& parameter : table.parameters()) {
        if (parameter.name == "wheels") {
            EXPECT_FALSE(parameter.parse("odometry_at_swep"));
        }
        if (parameter.name == "receiver") {
            EXPECT_FALSE(parameter.parse("gps"));
        }
    }
    module.start({});
    Unheard publisher;
    for (int k = 1; k < 20; ++k) module.process(pose_at(k, k), publisher);
    gnss::GnssFix fix;
    fix.stamp_ns = 5'000'000'000LL;
    fix.has_position = true;
    module.process({99, fix.stamp_ns, gnss::gps_observation(fix, "gnss")}, publisher);
    module.drain(publisher);
    Results results;
    module.finish(results);
    ASSERT_GE(results.warnings.size(), 2U);
    EXPECT_NE(results.warnings[0].find("no receiver has the label gps"), std::string::npos);
    EXPECT_NE(results.warnings[1].find("no wheel odometry with the label odometry_at_swep"),
              std::string::npos);
    EXPECT_EQ(std::get<std::int64_t>(results.metrics.at("gnss_of_other_receivers")), 1);
}

TEST(FusionModule, settings_that_do_not_go_together_are_refused) {
    const auto complaint = [](const std::vector<std::pair<std::string, std::string>>& keys) {
        FusionModule module;
        const ParameterTable table = module.parameters();
        for (const auto& [key, value] : keys)
            for (const auto& parameter : table.parameters())
                if (parameter.name == key) {
                    EXPECT_FALSE(parameter.parse(value)) << key;
                }
        return module.check();
    };
    EXPECT_EQ(complaint({}), "");
    EXPECT_NE(complaint({{"sync", "threshold"}}), "");
    EXPECT_EQ(complaint({{"sync", "threshold"}, {"filter", "paper"}}), "");
    EXPECT_NE(complaint({{"motion", ""}}), "");
    EXPECT_EQ(complaint({{"motion", ""}, {"wheels", "wheels"}}), "");
    EXPECT_NE(complaint({{"motion", ""}, {"wheels", "wheels"}, {"filter", "paper"}}), "");
    EXPECT_NE(complaint({{"motion", "fusion"}}), "");
    EXPECT_NE(complaint({{"motion", "fused_odometry"}}), "");
    EXPECT_NE(complaint({{"wheels", "calibrated_wheels"}}), "");
    EXPECT_NE(complaint({{"withhold_s", "300"}}), "");
    EXPECT_EQ(complaint({{"withhold_s", "30"}}), "");
    EXPECT_NE(complaint({{"withhold_s", "30"}, {"filter", "paper"}}), "");
}

TEST(FusionModule, leaves_the_reason_to_the_module_that_had_nothing_to_publish) {
    FusionModule module;
    module.start({});
    Results alone, with_reason;
    with_reason.refused = "there are no landmarks";
    module.finish(alone);
    module.finish(with_reason);
    ASSERT_TRUE(alone.refused);
    EXPECT_NE(alone.refused->find("no pose with the label lidar_mapping came"), std::string::npos);
    EXPECT_EQ(with_reason.refused, "there are no landmarks");
}

}  // namespace
