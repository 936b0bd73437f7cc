/// Motion model and line observation: every Jacobian against central differences, and the cases that go wrong
/// elsewhere.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <random>

#include "line_slam/feature.h"
#include "line_slam/line_input.h"
#include "line_slam/line_observation.h"
#include "line_slam/motion_model.h"

using namespace loopline;
using namespace loopline::line_slam;

namespace {

constexpr double h = 1e-6;

Eigen::Vector3d coordinates(const Pose2& p) {
    return {p.x_m, p.y_m, p.phi_rad};
}

struct LineSlamModels : ::testing::Test {
    std::mt19937_64 random{7};
    double uniform(double a, double b) { return std::uniform_real_distribution<double>(a, b)(random); }
    Pose2 pose() { return {uniform(-30, 30), uniform(-30, 30), uniform(-M_PI, M_PI)}; }
    PlanarLine line() { return {uniform(-30, 30), uniform(-M_PI, M_PI)}; }
};

TEST_F(LineSlamModels, wheel_travel_and_moved_are_inverse) {
    for (int i = 0; i < 200; ++i) {
        const Pose2 T{uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)};
        const Pose2 again = moved(wheel_travel(T, 0.4), 0.4);
        EXPECT_LT((coordinates(T) - coordinates(again)).norm(), 1e-12);
    }
}

TEST_F(LineSlamModels, motion_is_the_papers_mid_point_heading) {
    // Eq. (3) in MRPT's axes: v_l, v_r times the interval are the ways of the wheels.
    const double left_m = 0.0634, right_m = 0.0106, l = 0.42;
    const Pose2 T = moved({left_m, right_m, 0}, l);
    const double turn = (right_m - left_m) / l;
    EXPECT_DOUBLE_EQ(T.phi_rad, turn);
    EXPECT_NEAR(T.x_m, 0.5 * (left_m + right_m) * std::cos(0.5 * turn), 1e-15);
    EXPECT_NEAR(T.y_m, 0.5 * (left_m + right_m) * std::sin(0.5 * turn), 1e-15);
}

TEST_F(LineSlamModels, motion_jacobians_agree_with_central_differences) {
    for (int i = 0; i < 100; ++i) {
        const WheelTravel t{uniform(-1, 1), uniform(-1, 1), uniform(-0.1, 0.1)};
        const WheelCalibration c{uniform(-0.1, 0.1), uniform(-0.1, 0.1), uniform(-0.1, 0.1)};
        const MotionJacobians J = motion_jacobians(t, 0.5, c);
        for (int k = 0; k < 3; ++k) {
            Eigen::Vector3d d = Eigen::Vector3d::Zero();
            d(k) = h;
            const auto at = [&](double s) {
                return coordinates(
                    moved({t.left_m + s * d(0), t.right_m + s * d(1), t.side_m + s * d(2)}, 0.5, c));
            };
            const auto with = [&](double s) {
                return coordinates(
                    moved(t, 0.5, {c.left + s * d(0), c.right + s * d(1), c.track + s * d(2)}));
            };
            EXPECT_LT((J.travel.col(k) - (at(1) - at(-1)) / (2 * h)).norm(), 1e-8);
            EXPECT_LT((J.calibration.col(k) - (with(1) - with(-1)) / (2 * h)).norm(), 1e-8);
        }
    }
}

TEST_F(LineSlamModels,
       expected_travel_is_the_inverse_motion_and_its_jacobians_agree_with_central_differences) {
    for (int i = 0; i < 100; ++i) {
        const Pose2 T{uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)};
        const WheelCalibration c{uniform(-0.1, 0.1), uniform(-0.1, 0.1), uniform(-0.1, 0.1)};
        const auto travel = [](const Pose2& m, const WheelCalibration& k) {
            const WheelTravel t = expected_travel(m, 0.5, k).travel;
            return Eigen::Vector3d(t.left_m, t.right_m, t.side_m);
        };
        const ExpectedTravel e = expected_travel(T, 0.5, c);
        EXPECT_LT((coordinates(moved(e.travel, 0.5, c)) - coordinates(T)).norm(), 1e-12);
        for (int k = 0; k < 3; ++k) {
            Eigen::Vector3d d = Eigen::Vector3d::Zero();
            d(k) = h;
            const auto at = [&](double s) {
                return travel({T.x_m + s * d(0), T.y_m + s * d(1), T.phi_rad + s * d(2)}, c);
            };
            const auto with = [&](double s) {
                return travel(T, {c.left + s * d(0), c.right + s * d(1), c.track + s * d(2)});
            };
            EXPECT_LT((e.motion.col(k) - (at(1) - at(-1)) / (2 * h)).norm(), 1e-8);
            EXPECT_LT((e.calibration.col(k) - (with(1) - with(-1)) / (2 * h)).norm(), 1e-8);
        }
    }
}

TEST_F(LineSlamModels, observation_jacobians_agree_with_central_differences) {
    for (int i = 0; i < 100; ++i) {
        const Pose2 T = pose();
        const PlanarLine l = line();
        const ObservationJacobians H = observation_jacobians(T, l, l.normal());
        for (int k = 0; k < 5; ++k) {
            const auto at = [&](double s) {
                Eigen::Matrix<double, 5, 1> d = Eigen::Matrix<double, 5, 1>::Zero();
                d(k) = s;
                return predicted_line(corrected(T, d.head<3>()), {l.rho_m + d(3), l.alpha_rad + d(4)});
            };
            const Eigen::Vector2d numeric = difference(at(h), at(-h)) / (2 * h);
            const Eigen::Vector2d analytic =
                k < 3 ? Eigen::Vector2d(H.pose.col(k)) : Eigen::Vector2d(H.line.col(k - 3));
            EXPECT_LT((numeric - analytic).norm(), 1e-7) << "column " << k;
        }
    }
}

TEST_F(LineSlamModels, foot_points_jacobians_and_noise_agree_with_central_differences) {
    for (int i = 0; i < 100; ++i) {
        const Pose2 T = pose();
        const PlanarLine l = line();
        LineObservation z;
        z.line = predicted_line(T, {l.rho_m + 0.02, l.alpha_rad + 0.01});
        Eigen::Matrix2d R;
        R << 4e-4, 1e-4, 1e-4, 9e-4;
        const FeaturePrediction f = predict_feature(Feature::foot_point, T, l, l.normal(), z, R);
        if (f.noise(0, 0) > 1e6 || std::abs(l.rho_m) < 0.5) continue;
        // Where the map line's foot point is predicted: the measurement stays as it was.
        const Eigen::Vector2d o = T.inverse() * Eigen::Vector2d(0, 0);
        const auto polar = [](const Eigen::Vector2d& p) {
            return Eigen::Vector2d(p.norm(), std::atan2(p.y(), p.x()));
        };
        const auto difference = [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
            return Eigen::Vector2d(a.x() - b.x(), wrap_to_pi(a.y() - b.y()));
        };
        for (int k = 0; k < 5; ++k) {
            const auto at = [&](double s) {
                Eigen::Matrix<double, 5, 1> d = Eigen::Matrix<double, 5, 1>::Zero();
                d(k) = s;
                const PlanarLine moved{l.rho_m + d(3), l.alpha_rad + d(4)};
                return polar(corrected(T, d.head<3>()).inverse() * moved.point_m(0));
            };
            const Eigen::Vector2d numeric = difference(at(h), at(-h)) / (2 * h);
            const Eigen::Vector2d analytic =
                k < 3 ? Eigen::Vector2d(f.H.pose.col(k)) : Eigen::Vector2d(f.H.line.col(k - 3));
            EXPECT_LT((numeric - analytic).norm(), 1e-5 * (1 + analytic.norm())) << "column " << k;
        }
        Eigen::Matrix2d J;
        for (int k = 0; k < 2; ++k) {
            const auto at = [&](double s) {
                PlanarLine seen = z.line;
                (k == 0 ? seen.rho_m : seen.alpha_rad) += s;
                return polar(o + (seen.rho_m - seen.normal().dot(o)) * seen.normal());
            };
            J.col(k) = difference(at(h), at(-h)) / (2 * h);
        }
        const Eigen::Matrix2d noise = J * R * J.transpose();
        EXPECT_LT((f.noise - noise).norm(), 1e-5 * noise.norm());
    }
}

TEST_F(LineSlamModels, augmentation_jacobians_agree_with_central_differences) {
    for (int i = 0; i < 100; ++i) {
        const Pose2 T = pose();
        const PlanarLine z = line();
        const AugmentationJacobians G = augmentation_jacobians(T, transformed(T, z));
        for (int k = 0; k < 5; ++k) {
            const auto at = [&](double s) {
                Eigen::Matrix<double, 5, 1> d = Eigen::Matrix<double, 5, 1>::Zero();
                d(k) = s;
                return transformed(corrected(T, d.head<3>()), {z.rho_m + d(3), z.alpha_rad + d(4)});
            };
            const Eigen::Vector2d numeric = difference(at(h), at(-h)) / (2 * h);
            const Eigen::Vector2d analytic =
                k < 3 ? Eigen::Vector2d(G.pose.col(k)) : Eigen::Vector2d(G.observation.col(k - 3));
            EXPECT_LT((numeric - analytic).norm(), 1e-7) << "column " << k;
        }
    }
}

TEST_F(LineSlamModels, moving_the_whole_map_is_never_observed) {
    for (int i = 0; i < 100; ++i) {
        // A line is first seen from one pose, and again, when its estimate is another, from another one.
        const PlanarLine first = line(), later{first.rho_m + 0.3, first.alpha_rad + 0.2};
        const AugmentationJacobians G = augmentation_jacobians(pose(), first);
        const ObservationJacobians H = observation_jacobians(pose(), later, first.normal());
        EXPECT_LT((H.pose + H.line * G.pose).norm(), 1e-12);
    }
}

TEST_F(LineSlamModels, error_maps_agree_with_central_differences) {
    const Pose2 T = pose();
    for (int k = 0; k < 3; ++k) {
        Eigen::Vector3d d = Eigen::Vector3d::Zero();
        d(k) = h;
        const Eigen::Vector3d numeric =
            (coordinates(corrected(T, d)) - coordinates(corrected(T, -d))) / (2 * h);
        EXPECT_LT((numeric - coordinates_from_error(T).col(k)).norm(), 1e-7);
        // T Exp(d) = Exp(Ad d) T.
        const Pose2 right = T * Pose2{d(0), d(1), d(2)};
        EXPECT_LT((coordinates(right) - coordinates(corrected(T, adjoint(T) * d))).norm(), 1e-10);
    }
}

TEST(LineSlamInnovation, of_a_far_wall_is_zero_on_the_average_where_its_direction_is_vague) {
    // A stretch at 15 m, seen ahead, aside and obliquely: its middle to 5 mm, its direction to 1 degree.
    std::mt19937_64 random(4);
    std::normal_distribution<double> normal(0, 1);
    const double sigma_m = 0.005, sigma_rad = M_PI / 180;
    for (const double bearing_rad : {0.0, 0.4, -1.1}) {
        const PlanarLine wall{15, 0.3};
        const Eigen::Vector2d middle = wall.point_m(15 * std::tan(bearing_rad));
        Eigen::Vector2d sum = Eigen::Vector2d::Zero();
        const int n = 40000;
        for (int i = 0; i < n; ++i) {
            PlanarLine seen{0, wall.alpha_rad + sigma_rad * normal(random)};
            seen.rho_m = seen.normal().dot(middle) + sigma_m * normal(random);
            const Eigen::Vector2d v = innovation(seen, wall);
            // At the middle of the stretch as it was seen, which is where an observation's covariance has it.
            sum += Eigen::Vector2d(v.x() - seen.along_m(middle) * v.y(), v.y());
        }
        EXPECT_NEAR(sum.x() / n, 0, 4 * sigma_m / std::sqrt(n)) << "by the plain difference, 2.3 mm";
        EXPECT_NEAR(sum.y() / n, 0, 4 * sigma_rad / std::sqrt(n));
    }
}

TEST_F(LineSlamModels, innovation_wraps_the_angle_and_tells_the_two_faces_of_a_wall_apart) {
    EXPECT_NEAR(innovation({1, M_PI - 0.01}, {1, -M_PI + 0.01}).y(), -0.02, 1e-12);
    const PlanarLine west_face{5, 0}, east_face{-5.0, M_PI};  // the same points, seen from either side
    const Pose2 west{3, 0, 0.2}, east{7, 0, 0.2};
    EXPECT_GT(predicted_line(west, west_face).rho_m, 0);
    EXPECT_GT(predicted_line(east, east_face).rho_m, 0);
    EXPECT_NEAR(std::abs(innovation(predicted_line(east, east_face), predicted_line(east, west_face)).y()),
                M_PI, 1e-9);
}

TEST_F(LineSlamModels, covariance_in_the_base_frame_is_that_of_the_displaced_fit) {
    // Monte Carlo of the transformation alone.
    lines::LineSegment s;
    s.rho_m = 3;
    s.alpha_rad = 0.7;
    s.covariance << 4e-4, 1e-4, 1e-4, 1e-4;
    const PlanarLine sensor{s.rho_m, s.alpha_rad};
    s.start_m = sensor.point_m(-1);
    s.end_m = sensor.point_m(2);
    const Pose2 T_base_sensor{0.8, -0.3, 0.4};
    const LineObservation z = observation_in_base(s, T_base_sensor, 0);
    const Eigen::Matrix2d L = s.covariance.llt().matrixL();
    std::normal_distribution<double> normal;
    Eigen::Matrix2d sum = Eigen::Matrix2d::Zero();
    const int n = 20000;
    for (int i = 0; i < n; ++i) {
        const Eigen::Vector2d e = L * Eigen::Vector2d(normal(random), normal(random));
        const PlanarLine moved_line = transformed(T_base_sensor, {s.rho_m + e.x(), s.alpha_rad + e.y()});
        const Eigen::Vector2d d = innovation(moved_line, z.line);
        sum += d * d.transpose();
    }
    EXPECT_LT((sum / n - z.covariance).norm(), 0.05 * z.covariance.norm());
    // Uneven walls: the ends move by the stated sigma.
    const LineObservation rough = observation_in_base(s, T_base_sensor, 0.1);
    const Eigen::Matrix2d wall = rough.covariance - z.covariance;
    for (const Eigen::Vector2d& end : {z.start_m, z.end_m}) {
        const Eigen::Vector2d to_end(1, -z.line.along_m(end));  // offset of the end for (rho, alpha)
        EXPECT_NEAR(to_end.dot(wall * to_end), 0.01, 1e-6);
    }
}

TEST_F(LineSlamModels, deskewing_gives_the_line_that_a_vehicle_at_rest_would_see) {
    std::uniform_real_distribution<double> any(-1, 1);
    for (const double duration_s : {0.05, -0.05}) {
        const SweepTime sweep{duration_s, 181};
        EXPECT_EQ(sweep.after_stamp_s(duration_s > 0 ? 0 : 180), 0);
        EXPECT_DOUBLE_EQ(sweep.after_stamp_s(duration_s > 0 ? 180 : 0), 0.05);
        for (int i = 0; i < 20; ++i) {
            const Twist2 velocity{2 * any(random), 0.1 * any(random), any(random)};
            const Pose2 T_base_sensor{0.4, 0.1, 0.2};
            const PlanarLine wall_base{3, 0.5 * any(random)};  // at the stamp
            // Every beam measures from where the vehicle is at its time.
            std::vector<Eigen::Vector2d> points_sensor;
            lines::LineSegment s;
            for (std::size_t beam = 60; beam <= 120; ++beam) {
                const double a = (static_cast<double>(beam) - 90) * M_PI / 180;
                const Pose2 T_base_now = exp_se2(velocity * sweep.after_stamp_s(beam)) * T_base_sensor;
                const PlanarLine seen = predicted_line(T_base_now, wall_base);
                const double range_m = seen.rho_m / std::cos(a - seen.alpha_rad);
                points_sensor.emplace_back(range_m * std::cos(a), range_m * std::sin(a));
            }
            s.first_beam = 60;
            s.last_beam = 120;
            s.start_m = points_sensor.front();
            s.end_m = points_sensor.back();
            const Eigen::Vector2d t = (s.end_m - s.start_m).normalized(), n(t.y(), -t.x());
            s.alpha_rad = std::atan2(n.y(), n.x());
            s.rho_m = n.dot(s.start_m);
            LineObservation z = observation_in_base(s, T_base_sensor, 0);
            const Eigen::Vector2d skewed = innovation(z.line, wall_base);
            deskew(s, sweep, {velocity, Eigen::Matrix3d::Zero()}, z);
            const Eigen::Vector2d left = innovation(z.line, wall_base);
            EXPECT_LT(left.norm(), 1e-9);
            EXPECT_LT(left.norm(), 1e-3 * skewed.norm());
            EXPECT_NEAR(z.line.normal().dot(z.start_m), z.line.rho_m, 1e-9);
        }
    }
}

}  // namespace
