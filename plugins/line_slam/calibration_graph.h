/// Least squares over poses, walls and slip: what a drive's measurements say about its wheels once walls tell
/// its motion, and how likely a noise makes them. Derivation: docs/papers/calibration.md.
///
/// A piece of the drive rolled m on a wheel and moved over ground by expected_travel() of its motion:
///     ground = (1 - slip of the regime - deviation of the stretch) m + noise,
/// linear in all that is asked for but the poses.
#pragma once

#include <vector>

#include "api/twist2.h"
#include "least_squares/selected_inverse.h"
#include "line_slam/drive_noise.h"
#include "line_slam/pose_line_graph.h"
#include "line_slam/symmetric_sum.h"
#include "line_slam/wide_interval.h"

namespace loopline::line_slam {

/// Where slips and track stand among the scales.
constexpr int track_scale = wheel_kinds;  ///< slips before it, in the order of wheel_noise()
constexpr int delay_scale = track_scale + 1;
constexpr int scale_count = delay_scale + 1;

struct CalibrationGraph {
    struct Piece {
        DrivePiece drive;
        int stretch = 0;  ///< of consecutive pieces under one regime, whose slip is one
    };
    std::vector<Pose2> poses;        ///< at steps, and where the regime changes between two; [0] stays
    std::vector<Twist2> velocities;  ///< there, by the control; a second
    /// Two lines that are one wall, but for its unevenness.
    struct Tie {
        int wall = 0, patch = 0;
        Eigen::Matrix2d information;  ///< of the difference of (rho, alpha)
    };
    std::vector<PlanarLine> lines;
    std::vector<Tie> ties;
    std::vector<Piece> pieces;  ///< [k] from pose k - 1 to pose k; [0] is unused
    std::vector<GraphObservation> observations;
    double track_width_m = 0.5;

    RegimeWheelValues slip{};
    double track = 0;                     ///< true track width = (1 + track) x track_width_m
    std::vector<WheelValues> deviations;  ///< of each stretch's slip from the regime's

    double delay_s = 0;  ///< walls were seen so much later than the poses' times say

    double sigma_slip = 1;  ///< of slip, a priori: as good as nothing
    double sigma_delay_s = 0.1;
    double sigma_track = 1;  ///< of track, a priori
};

class CalibrationSolver {
 public:
    /// Chooses the elimination order for this graph's ties; they must not change as long as the solver is
    /// used.
    explicit CalibrationSolver(const CalibrationGraph& graph);

    /// Poses, lines, slip and deviations that are likeliest with this noise. False if the equations are
    /// singular or nothing converges.
    bool minimise(CalibrationGraph& graph, const NoiseVector& log_variance);

    /// Of the noise, poses, lines and slip integrated out, at the graph's minimum for this noise.
    struct Likelihood {
        double minus_two_log = 0;
        NoiseVector gradient = NoiseVector::Zero();  ///< of log L
        NoiseMatrix information =
            NoiseMatrix::Zero();  ///< average information: of log L, about minus its Hessian
    };
    Likelihood likelihood(const CalibrationGraph& graph, const NoiseVector& log_variance);
    /// The first part of it alone.
    double minus_two_log_likelihood(const CalibrationGraph& graph, const NoiseVector& log_variance);

    /// Covariance of (slips by regime and wheel, track), given the noise. Infinite if the equations are
    /// singular.
    using ScaleMatrix = Eigen::Matrix<double, scale_count, scale_count>;
    ScaleMatrix scale_covariance(const CalibrationGraph& graph, const NoiseVector& log_variance);

 private:
    struct Row;
    Eigen::Index pose_column(int pose) const { return 3 * (pose - 1); }
    Eigen::Index line_column(int line) const { return 3 * (pose_count_ - 1) + 2 * line; }
    Eigen::Index slip_column(Regime regime, Wheel wheel) const {
        return line_column(line_count_) + wheel_noise(regime, wheel);
    }
    Eigen::Index track_column() const { return line_column(line_count_) + track_scale; }
    Eigen::Index delay_column() const { return line_column(line_count_) + delay_scale; }
    Eigen::Index deviation_column(int stretch, Wheel wheel) const {
        return line_column(line_count_) + scale_count + wheel_count * stretch + static_cast<int>(wheel);
    }
    Eigen::Index columns() const { return deviation_column(stretch_count_, Wheel::left); }

    std::vector<Row> rows(const CalibrationGraph& graph, const NoiseVector& log_variance) const;
    void linearise(const CalibrationGraph& graph, const std::vector<Row>& rows);
    bool factorise();
    double cost(const CalibrationGraph& graph, const std::vector<Row>& rows) const;
    void move(CalibrationGraph& graph, const Eigen::VectorXd& dx) const;

    int pose_count_, line_count_, stretch_count_;
    SymmetricSum H_;
    Eigen::VectorXd gradient_;
    least_squares::SparseLdlt ldlt_;
    bool analysed_ = false;
};

}  // namespace loopline::line_slam
