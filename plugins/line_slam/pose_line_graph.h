/// Least squares over all poses and lines: wheel odometry between neighbours, line observations, a robust
/// loss. Its minimum is what the filter's data say without the filter's own linearisation history.
#pragma once

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <vector>

#include "line_slam/cauchy_loss.h"
#include "line_slam/line_observation.h"
#include "line_slam/motion_model.h"

namespace loopline::line_slam {

struct GraphMotion {
    WheelTravel travel;                                     ///< measured
    Eigen::Matrix3d information = Eigen::Matrix3d::Zero();  ///< of it
};

struct GraphObservation {
    int pose = 0;
    int line = 0;
    PlanarLine observed_base;
    Eigen::Matrix2d information = Eigen::Matrix2d::Zero();  ///< of (rho, alpha)
};

/// Poses and lines, and what ties them. Pose 0 stays where it is.
struct PoseLineGraph {
    std::vector<Pose2> poses;
    std::vector<PlanarLine> lines;
    double track_width_m = 0.5;
    WheelCalibration calibration;
    double sigma_scale = 0.05;                   ///< of the calibration, a priori
    std::vector<GraphMotion> motions;            ///< [k] from pose k - 1 to pose k; [0] is unused
    std::vector<GraphObservation> observations;  ///< ordered by pose, then line
    CauchyLoss loss{3};                          ///< of the observations
};

/// Sum of all squared whitened residuals, the observations' under the robust loss.
double graph_cost(const PoseLineGraph& graph);

/// Gauss-Newton with Levenberg's damping on the sparse normal equations.
class GraphSolver {
 public:
    /// Chooses the elimination order for this graph's ties; they must not change as long as the solver is
    /// used.
    explicit GraphSolver(const PoseLineGraph& graph);

    struct Outcome {
        bool converged = false;
        int iterations = 0;
        double initial_cost = 0;
        double final_cost = 0;
    };
    Outcome minimise(PoseLineGraph& graph, int max_iterations);

    /// Factorises the undamped normal equations at the graph's present values, with the loss's information
    /// factor; needed before those below.
    bool factorise(const PoseLineGraph& graph);
    /// Covariances of (x, y, phi) of every pose; zero for pose 0.
    std::vector<Eigen::Matrix3d> pose_covariances() const;
    /// Covariances of (rho, alpha) of every line.
    std::vector<Eigen::Matrix2d> line_covariances() const;
    /// Covariance of line a minus line b.
    Eigen::Matrix2d line_difference_covariance(int a, int b) const;

 private:
    using Sparse = Eigen::SparseMatrix<double>;
    Eigen::Index pose_row(int pose) const { return 3 * (pose - 1); }
    Eigen::Index line_row(int line) const { return 3 * (pose_count_ - 1) + 2 * line; }
    Eigen::Index calibration_row() const { return line_row(line_count_); }
    void lay_out(const PoseLineGraph& graph);
    /// `information_factor`: of every observation's weighted information.
    void linearise(const PoseLineGraph& graph, double information_factor = 1);

    int pose_count_ = 0, line_count_ = 0;
    Sparse H_;  ///< lower triangle
    Eigen::VectorXd gradient_;
    std::vector<Eigen::Index>
        line_slot_;  ///< per observation: place of its line's block below its pose's columns
    Eigen::SimplicialLDLT<Sparse> ldlt_;
    mutable Sparse inverse_;  ///< entries of H^-1 on the factor's pattern, permuted
};

}  // namespace loopline::line_slam
