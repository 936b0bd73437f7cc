/// Three receivers with carrier phases on one vehicle: MRPT's sample of a path, from its own program.
#include <gtest/gtest.h>
#include <mrpt/obs/CObservationGPS.h>

#include <Eigen/Geometry>
#include <filesystem>
#include <map>

#include "gnss/gps_observation.h"
#include "gnss/local_frame.h"
#include "gnss/utm.h"
#include "pipeline/log_source.h"

using namespace loopline;
using namespace loopline::gnss;

namespace {

const char* const rtk_path = "/usr/share/mrpt/datasets/test_rtk_path.rawlog";

using FixesOf = std::map<std::string, std::map<StampNs, GnssFix>>;

/// By receiver and stamp.
FixesOf fixes_of_rtk_path() {
    FixesOf fixes;
    LogSource source({rtk_path});
    for (StreamItem item; source.next(item);)
        if (const auto gps = std::dynamic_pointer_cast<const mrpt::obs::CObservationGPS>(item.observation)) {
            const auto fix = fix_from_mrpt(*gps, item.stamp_ns);
            EXPECT_TRUE(fix && fix->has_position && fix->has_height);
            if (fix) fixes[gps->sensorLabel].emplace(item.stamp_ns, *fix);
        }
    return fixes;
}

#define NEEDS_RTK_PATH() \
    if (!std::filesystem::exists(rtk_path)) GTEST_SKIP() << rtk_path << " is not there (package mrpt-common)"

}  // namespace

TEST(RtkPath, fixed_antennas_keep_the_distance_of_their_mounts_and_float_ones_do_not) {
    NEEDS_RTK_PATH();
    const FixesOf fixes = fixes_of_rtk_path();
    const auto &left = fixes.at("GPS_RTK_FRONT_L"), &right = fixes.at("GPS_RTK_FRONT_R");
    EXPECT_EQ(left.size(), 307u);
    EXPECT_EQ(right.size(), 307u);
    EXPECT_EQ(fixes.at("GPS_RTK_REAR").size(), 77u);
    const LocalFrame frame(left.begin()->second.antenna);
    int fixed = 0, floating = 0;
    for (const auto& [stamp_ns, l] : left) {
        const auto partner = right.find(stamp_ns);
        if (partner == right.end()) continue;
        const GnssFix& r = partner->second;
        EXPECT_EQ(l.quality, FixQuality::rtk_fixed);
        const double apart_m = (frame.p_enu_m(l.antenna) - frame.p_enu_m(r.antenna)).head<2>().norm();
        const double mounted_m = (l.p_base_antenna_m - r.p_base_antenna_m).norm();
        if (r.quality == FixQuality::rtk_fixed) {
            EXPECT_NEAR(apart_m, mounted_m, 0.08) << seconds_text(stamp_ns);
            ++fixed;
        } else {
            EXPECT_EQ(r.quality, FixQuality::rtk_float);
            EXPECT_GT(apart_m, mounted_m + 1) << seconds_text(stamp_ns);
            ++floating;
        }
    }
    EXPECT_EQ(fixed, 268);
    EXPECT_EQ(floating, 8);
}

TEST(RtkPath, is_as_long_as_the_receiver_was_fast_and_the_same_on_both_grids) {
    NEEDS_RTK_PATH();
    const FixesOf fixes = fixes_of_rtk_path();
    const auto& left = fixes.at("GPS_RTK_FRONT_L");
    const LocalFrame frame(left.begin()->second.antenna);
    double enu_m = 0, utm_m = 0, doppler_m = 0;
    const GnssFix* last = nullptr;
    for (const auto& [stamp_ns, fix] : left) {
        if (last != nullptr) {
            const double step_s = seconds_between(last->stamp_ns, fix.stamp_ns);
            doppler_m += (*last->speed_mps + *fix.speed_mps) / 2 * step_s;
            const Eigen::Vector2d enu = (frame.p_enu_m(fix.antenna) - frame.p_enu_m(last->antenna)).head<2>();
            const auto a = to_utm(last->antenna), b = to_utm(fix.antenna);
            ASSERT_TRUE(a && b);
            EXPECT_EQ(a->zone, 30);
            // Lengths of the grid are those of the ellipsoid times its scale, the antenna is h above it: 1 +
            // h / R.
            const double to_ground = (1 + fix.antenna.height_m / 6.37e6) / a->scale;
            const Eigen::Vector2d grid(b->easting_m - a->easting_m, b->northing_m - a->northing_m);
            EXPECT_NEAR(grid.norm() * to_ground, enu.norm(), 2e-4);
            // Grid north is clockwise from true north by the convergence.
            const Eigen::Vector2d turned = Eigen::Rotation2Dd(-a->convergence_rad) * grid * to_ground;
            EXPECT_NEAR((turned - enu).norm(), 0, 2e-4);
            enu_m += enu.norm();
            utm_m += grid.norm() * to_ground;
        }
        last = &fix;
    }
    EXPECT_NEAR(enu_m, 310, 1);
    EXPECT_NEAR(utm_m, enu_m, 1e-3);
    EXPECT_NEAR(doppler_m, enu_m, 0.01 * enu_m) << "by Doppler shifts, which know no place";
}
