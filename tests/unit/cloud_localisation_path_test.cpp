/// The path of a drive that was lost for a while in a finished cloud, laid out from where it was found again.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <random>

#include "cloud_localisation/localised_path.h"
#include "inertial/rotation_vector.h"

using namespace loopline;
using namespace loopline::cloud_localisation;

namespace {

using Vector6d = Eigen::Matrix<double, 6, 1>;

/// Straight on, 1 m a sweep; what the motion between two sweeps errs by is independent of all others.
struct LostDrive {
    static constexpr int lost = 3, found = 43, sweeps = 46;
    Matrix6d at_an_end = Matrix6d::Zero(), a_step = Matrix6d::Zero();
    std::mt19937_64 random;
    std::normal_distribution<double> normal;

    explicit LostDrive(std::uint64_t seed) : random(seed) {
        at_an_end.diagonal() << 4e-4, 4e-4, 4e-4, 1e-8, 1e-8, 1e-8;
        a_step.diagonal() << 0.04, 1e-4, 1e-4, 1e-10, 1e-10, 1e-10;
    }
    static Pose3 truth(int k) {
        return {{20.0 + k, -7, 2}, Eigen::Quaterniond(Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitZ()))};
    }
    Vector6d draw(const Matrix6d& covariance) {
        Vector6d e;
        for (int i = 0; i < 6; ++i) e[i] = std::sqrt(covariance(i, i)) * normal(random);
        return e;
    }
    static Pose3 off(const Pose3& pose, const Vector6d& e) {
        return {pose.translation_m + e.head<3>(), inertial::exp_so3(e.tail<3>()) * pose.rotation};
    }
    /// Where the search's frame is seems to be `moved` from where it is at both ends.
    Trajectory path(const Eigen::Vector3d& moved_m) {
        LocalisedPath path;
        const Pose3 T_map_local = truth(lost);
        const Matrix6d to_local = [&] {
            Matrix6d R = Matrix6d::Zero();
            R.topLeftCorner<3, 3>() = R.bottomRightCorner<3, 3>() =
                T_map_local.rotation.conjugate().toRotationMatrix();
            return R;
        }();
        Vector6d astray = Vector6d::Zero();
        Pose3 T_local_base;
        Matrix6d of_motion = Matrix6d::Zero();
        for (int k = 0; k < sweeps; ++k) {
            LocalisedSweep sweep;
            if (k > lost && k <= found) {
                astray += draw(a_step);
                of_motion += to_local * a_step * to_local.transpose();
            }
            T_local_base = T_map_local.inverse() * off(truth(k), astray);
            sweep.known = k < lost || k >= found;
            sweep.T_map_base = off(truth(k), draw(at_an_end));
            sweep.covariance = at_an_end;
            if (k >= lost && k <= found) {
                sweep.T_local_base = T_local_base;
                sweep.local_covariance = of_motion;
            }
            if (k == lost) {
                sweep.begins_search = true;
                sweep.lost_at = PoseWithCovariance{off(truth(k), draw(at_an_end)), at_an_end};
                sweep.lost_at->T_map_base.translation_m += moved_m;
            }
            if (k == found) sweep.T_map_local = sweep.T_map_base * T_local_base.inverse();
            path.add(static_cast<std::uint64_t>(k), 1000 * k, sweep);
        }
        Trajectory trajectory;
        path.lay_out(trajectory);
        return trajectory;
    }
};

Vector6d error(const Trajectory& path, int k) {
    const auto entry = path[static_cast<std::size_t>(k)];
    const Pose3 truth = LostDrive::truth(k);
    Vector6d e;
    e << entry.T_map_base.translation_m - truth.translation_m,
        inertial::log_so3(entry.T_map_base.rotation * truth.rotation.conjugate());
    return e;
}

}  // namespace

TEST(LocalisedPath, is_as_uncertain_between_two_ends_as_it_claims) {
    constexpr int runs = 200;
    for (const int k : {LostDrive::lost, 10, 23, 40}) {
        double chi2 = 0, square_m2 = 0;
        for (int run = 0; run < runs; ++run) {
            const Trajectory path = LostDrive(static_cast<std::uint64_t>(run)).path({0, 0, 0});
            ASSERT_EQ(path.size(), static_cast<std::size_t>(LostDrive::sweeps));
            const Vector6d e = error(path, k);
            chi2 += e.dot(path[static_cast<std::size_t>(k)].covariance.matrix().ldlt().solve(e)) / runs;
            square_m2 += e[0] * e[0] / runs;
        }
        // 99 % of means of 200 lie between.
        EXPECT_GT(chi2, 5.4) << k;
        EXPECT_LT(chi2, 6.65) << k;
        // From one end alone 0.2 m times the root of 40 steps at its farthest; from two, half of that.
        EXPECT_LT(std::sqrt(square_m2), 0.75) << k;
    }
}

TEST(LocalisedPath, is_that_from_where_it_was_found_if_the_ends_contradict_each_other) {
    const Trajectory path = LostDrive(5).path({0, 0, 30});
    for (int k = LostDrive::lost; k <= LostDrive::found; ++k)
        EXPECT_LT(std::abs(error(path, k)[2]), 0.3) << k;
    const Trajectory agreeing = LostDrive(5).path({0, 0, 0});
    EXPECT_LT(error(agreeing, LostDrive::lost).norm(), 0.1);
}
