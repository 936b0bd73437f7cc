/// What a fix is worth.
#include <gtest/gtest.h>

#include <cmath>

#include "gnss/fix_noise.h"

using namespace loopline;
using namespace loopline::gnss;

TEST(FixNoise, reported_deviations_count_only_if_they_are_worse_than_the_kind_of_fix) {
    const FixNoiseSettings settings;
    GnssFix fix;
    fix.quality = FixQuality::single;
    const SigmaOfFix plain = sigma_of(fix, settings);
    EXPECT_EQ(plain.white_m.x(), settings.single.white_m);
    EXPECT_EQ(plain.correlated_m.z(), 2 * settings.single.correlated_m);
    fix.sigma_enu_m = Eigen::Vector3d(0.1, 0.1, 0.1);
    EXPECT_EQ(sigma_of(fix, settings).correlated_m, plain.correlated_m) << "too good to be true";
    fix.sigma_enu_m = Eigen::Vector3d(20, 20, 40);
    const SigmaOfFix poor = sigma_of(fix, settings);
    EXPECT_NEAR(std::hypot(poor.white_m.x(), poor.correlated_m.x()), 20, 1e-9);
}
