/// What a view says of a whole box against what it says of each place in it.
#include <gtest/gtest.h>

#include "cloud_map/clear_image.h"
#include "support/spinning_world.h"

using namespace loopline;
using namespace loopline::cloud_map;

namespace {

/// From a vehicle that drives, turns and pitches fast; of its beams some find nothing.
lidar::SpinningScan fast_sweep(const test::SpinningBeams& beams, const Pose3& T_map_lidar,
                               const Twist3& per_s, SweepMotion& motion, std::mt19937_64& random) {
    const auto pose_after = [&](double t_s) { return T_map_lidar * exp_se3(per_s * t_s); };
    const auto whole = test::sweep_in(test::walled_yard(), pose_after, 0, beams, random);
    lidar::SpinningScan scan = whole;
    scan.points.clear();
    scan.ring_begin.clear();
    std::bernoulli_distribution comes_back(0.9);
    for (std::size_t ring = 0; ring < whole.rings(); ++ring) {
        scan.ring_begin.push_back(static_cast<std::uint32_t>(scan.points.size()));
        for (std::uint32_t i = whole.ring_begin[ring]; i < whole.ring_begin[ring + 1]; ++i)
            if (comes_back(random)) scan.points.push_back(whole.points[i]);
    }
    scan.ring_begin.push_back(static_cast<std::uint32_t>(scan.points.size()));
    EXPECT_TRUE(motion.follow(scan, [&](StampNs t) { return pose_after(1e-9 * double(t)); }));
    return scan;
}

bool looks_through_any(const RangeView& view, const Eigen::Vector3f& first_m,
                       const std::array<int, 3>& places) {
    for (int x = 0; x < places[0]; ++x)
        for (int y = 0; y < places[1]; ++y)
            for (int z = 0; z < places[2]; ++z)
                if (view.look(first_m + 0.1f * Eigen::Vector3f(float(x), float(y), float(z)), {}) ==
                    Evidence::through)
                    return true;
    return false;
}

}  // namespace

TEST(CloudMapClearImage, passes_over_no_box_with_a_place_that_was_looked_through_and_over_most_others) {
    std::mt19937_64 random(21);
    std::uniform_real_distribution<double> unit(-1, 1);
    std::uniform_int_distribution<int> places(1, 8), kind(0, 2);
    test::SpinningBeams few, many, dense;
    few.rings = 16, few.columns = 450;
    many.rings = 64, many.columns = 1200;
    dense.rings = 64, dense.columns = 600, dense.highest_rad = 0.02, dense.lowest_rad = -0.08;
    int with_place = 0, without = 0, passed_over = 0;
    for (const test::SpinningBeams& beams : {few, many, dense})
        for (int drive = 0; drive < 4; ++drive) {
            const Pose3 T_map_lidar(
                {20 * unit(random), unit(random), 1.8},
                Eigen::Quaterniond(Eigen::AngleAxisd(3 * unit(random), Eigen::Vector3d::UnitZ()) *
                                   Eigen::AngleAxisd(0.1 * unit(random), Eigen::Vector3d::UnitY())));
            const Twist3 per_s{{20 * unit(random), unit(random), unit(random)},
                               {0.3 * unit(random), 0.3 * unit(random), 1.5 * unit(random)}};
            SweepMotion motion;
            const auto scan = fast_sweep(beams, T_map_lidar, per_s, motion, random);
            const RangeView view(scan, motion);
            const ClearImage clear(view);
            std::uniform_int_distribution<std::size_t> any(0, scan.points.size() - 1);
            for (int k = 0; k < 3000; ++k) {
                const std::array<int, 3> size{places(random), places(random), places(random)};
                // On a surface, before or behind it, or anywhere.
                const auto& point = scan.points[any(random)];
                const double part = kind(random) == 0 ? 1 + 0.3 * unit(random) : 1;
                Eigen::Vector3f middle_m = (part * (motion.p_map_m(point) - view.origin_m())).cast<float>();
                if (kind(random) == 0)
                    middle_m =
                        Eigen::Vector3d(30 * unit(random), 20 * unit(random), 4 * unit(random)).cast<float>();
                const Eigen::Vector3f half_m =
                    0.05f * Eigen::Vector3f(float(size[0] - 1), float(size[1] - 1), float(size[2] - 1));
                const bool may = clear.may_look_through(view, middle_m, half_m, {});
                if (looks_through_any(view, middle_m - half_m, size)) {
                    ASSERT_TRUE(may) << middle_m.transpose() << " +- " << half_m.transpose();
                    ++with_place;
                } else {
                    ++without;
                    passed_over += may ? 0 : 1;
                }
            }
        }
    EXPECT_GT(with_place, 4000);
    EXPECT_GT(double(passed_over), 0.75 * without);
}

TEST(CloudMapClearImage, knows_no_box_about_the_lidar_or_out_of_reach) {
    std::mt19937_64 random(22);
    SweepMotion motion;
    const auto scan = fast_sweep({}, Pose3({0, 0, 1.8}, Eigen::Quaterniond::Identity()),
                                 {{10, 0, 0}, {0, 0, 1}}, motion, random);
    const RangeView view(scan, motion);
    const ClearImage clear(view);
    const Eigen::Vector3f half_m = Eigen::Vector3f::Constant(0.4f);
    EXPECT_TRUE(clear.may_look_through(view, {0.1f, 0, 0}, half_m, {}));
    EXPECT_FALSE(clear.may_look_through(view, {10, 0, 20}, half_m, {}));   // above all beams
    EXPECT_FALSE(clear.may_look_through(view, {10, 0, -20}, half_m, {}));  // below
    EXPECT_FALSE(clear.may_look_through(view, {60, 0, 0}, half_m, {}));
    EXPECT_FALSE(ClearImage().may_look_through(view, {5, 0, 0}, half_m, {}));
}
