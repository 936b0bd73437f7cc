/// What of the errors of sweeps adds up along the way.
#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "lidar_mapping/lasting_error.h"

using namespace loopline;
using namespace loopline::lidar_mapping;

namespace {

TEST(LastingError, is_what_the_surfaces_are_renewed_by_or_all_where_hardly_anything_holds) {
    Registration found;
    found.age_sweeps = 25;
    found.mean_range_m = 20;
    const double well_m = 0.0005, badly_m = 0.05;
    found.by_scan.diagonal() << well_m * well_m, badly_m * badly_m, well_m * well_m,
        Eigen::Vector3d::Constant(well_m * well_m / 400);
    const Matrix6d lasting = what_lasts(found);
    for (const Eigen::Index held : {0, 2, 3, 4, 5})
        EXPECT_NEAR(lasting(held, held) / found.by_scan(held, held), 1 / 25.0, 0.001) << held;
    EXPECT_NEAR(lasting(1, 1) / found.by_scan(1, 1), 1, 0.001);
    // A turn counts by what it moves: as badly held as the shift.
    found.by_scan(5, 5) = badly_m * badly_m / 400;
    EXPECT_NEAR(what_lasts(found)(5, 5) / found.by_scan(5, 5), 1, 0.001);
    // A map of this sweep alone is no older than it.
    found.age_sweeps = 0.5;
    EXPECT_LT((what_lasts(found) - found.by_scan).cwiseAbs().maxCoeff(), 1e-12);
}

/// Sweeps that leave a direction free, every tenth of which finds back: what is new adds up to what the pose
/// was off by.
TEST(LastingError, what_is_new_adds_up_to_the_pose_s_error) {
    std::mt19937_64 random(5);
    std::normal_distribution<double> normal;
    constexpr int runs = 20000, sweeps = 30;
    constexpr double moved_m = 0.1;
    std::vector<double> off_m(runs), added_m(runs);
    double told_m2 = 0, free_m2 = 0;
    for (int k = 0; k < sweeps; ++k) {
        Registration found;
        const double left = k % 10 == 9 ? 0 : 1;  // every tenth one finds back
        found.left.setIdentity();
        found.left(0, 0) = left;
        Matrix6d before = Matrix6d::Zero();
        before(0, 0) = free_m2;
        free_m2 = left * left * (free_m2 + moved_m * moved_m);
        found.by_prediction(0, 0) = free_m2;
        told_m2 += what_is_new(found, before)(0, 0);
        for (int run = 0; run < runs; ++run) {
            const auto r = static_cast<std::size_t>(run);
            const double now_m = left * (off_m[r] + moved_m * normal(random));
            added_m[r] += now_m - left * off_m[r];
            off_m[r] = now_m;
        }
    }
    double square_m2 = 0;
    for (const double m : added_m) square_m2 += m * m / runs;
    EXPECT_NEAR(told_m2 / square_m2, 1, 0.03);
}

/// Of a correction, what makes up for an error of the pose before and what for an acceleration: as the mean
/// of those drawn that give it.
TEST(LastingError, of_coming_back_is_the_part_of_the_correction_that_the_pose_before_answers_for) {
    std::mt19937_64 random(3);
    std::normal_distribution<double> normal;
    const double free_m = 0.5, moved_m = 0.2;
    Registration found;
    found.predicted *= 1e-4;
    found.predicted(0, 0) = free_m * free_m + moved_m * moved_m;
    Matrix6d before = Matrix6d::Zero();
    before(0, 0) = free_m * free_m;
    for (const double correction_m : {0.0, 0.3, -1.2}) {
        double sum_m = 0;
        int n = 0;
        for (int k = 0; k < 200000; ++k) {
            const double left_free_m = free_m * normal(random),
                         both_m = left_free_m + moved_m * normal(random);
            if (std::abs(both_m - correction_m) > 0.05) continue;
            sum_m += left_free_m;
            ++n;
        }
        found.correction[0] = correction_m;
        EXPECT_NEAR(std::sqrt(of_coming_back(found, before)(0, 0)), std::abs(sum_m / n), 0.01)
            << correction_m;
    }
    found.correction[0] = 0.3;
    EXPECT_LT(of_coming_back(found, 1e-6 * before).norm(), 1e-9) << "the surroundings held it before";
}

}  // namespace
