/// The state (pose, wheel calibration and map lines), its covariance, and everything that changes them.
///
/// Lines near the vehicle are active; the others are passive. Updates touch the active part alone and gather
/// what they mean for the passive part, which is brought up to date when the active set changes: exactly the
/// full filter's result, at a cost per scan that does not grow with the map (the compressed filter of Guivant
/// and Nebot 2001).
///
/// Errors are those of line_observation.h: invariant for the pose, plain (rho, alpha) for lines. So the
/// motion model's pose Jacobian, eq. (5), is the identity, and eq. (6) leaves the cross covariance alone.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "line_slam/feature.h"
#include "line_slam/motion_model.h"

namespace loopline::line_slam {

/// An observation that was recognised as a map line.
struct Pairing {
    int line = 0;         ///< id in the filter
    int observation = 0;  ///< index within the scan
};

/// How all pairings of a scan enter the state. `paper_sum` is eq. (14)-(16) as printed: gains that were each
/// computed from the same prior covariance are added up, as if the pairings did not know of one another. The
/// covariance gets too small, and may lose its positive definiteness.
enum class Update { joint, paper_sum };

struct EkfParameters {
    DriveParameters drive;
    Feature feature = Feature::line;
    Update update = Update::joint;
};

class Ekf {
 public:
    /// At the origin of the map, without error: the map frame is the first pose.
    explicit Ekf(const EkfParameters& parameters);
    explicit Ekf(const DriveParameters& drive) : Ekf(EkfParameters{drive, Feature::line, Update::joint}) {}

    const Pose2& T_map_base() const { return T_map_base_; }
    const WheelCalibration& calibration() const { return calibration_; }
    /// A passive line's value may lag behind until it is activated.
    const PlanarLine& line(int id) const { return lines_[static_cast<std::size_t>(id)]; }
    bool is_active(int id) const { return slot(id).part == Part::active; }
    bool exists(int id) const { return slot(id).part != Part::gone; }
    const std::vector<int>& active_lines() const { return active_; }
    const std::vector<int>& passive_lines() const { return passive_; }
    /// Ids that were ever given: 0 .. line_ids() - 1.
    int line_ids() const { return static_cast<int>(lines_.size()); }

    /// Covariance of the pose's (x, y, phi).
    Eigen::Matrix3d pose_covariance() const;
    /// Covariance of the pose's invariant error (t_x, t_y, theta).
    Eigen::Matrix3d pose_error_covariance() const { return P_aa_.topLeftCorner<3, 3>(); }
    /// Covariance of an active line's (rho, alpha).
    Eigen::Matrix2d line_covariance(int id) const;
    /// H_i P H_j^T of two active lines' observations, eq. (12) without R.
    Eigen::Matrix2d predicted_covariance(int id_i, int id_j) const;
    /// v of eq. (13), and its R, of one sighting by itself.
    FeaturePrediction prediction(int id, const LineObservation& observation) const {
        return predict_feature(parameters_.feature, T_map_base_, line(id), observation,
                               observation.covariance);
    }

    /// Eq. (3)-(6), piece by piece.
    void predict(const std::vector<MotionPiece>& motion);
    /// The same for one piece with the drive's own noise.
    void predict(const WheelTravel& travel) {
        predict({MotionPiece{travel, travel_covariance(travel, parameters_.drive)}});
    }

    /// What the last motion added to the pose's error: noise and calibration.
    const Eigen::Matrix3d& motion_error_covariance() const { return motion_error_covariance_; }
    /// Adds `factor` times the last motion's noise once more; negative takes it back, before any update.
    void doubt_motion(double factor);

    /// Joint update by all pairings at once, of active lines. False if the innovation's covariance is not
    /// positive definite or the result is not finite: the state is then as it was.
    bool update(const std::vector<Pairing>& pairings, const std::vector<LineObservation>& observations);

    /// Section 3.6: a new active line from an observation of now; returns its id.
    int augment(const LineObservation& observation);

    /// Two active lines that are one wall, up to a difference of covariance `slack`.
    struct SameWall {
        int kept, gone;
        Eigen::Matrix2d slack;
    };
    /// Squared Mahalanobis distance of all these differences together; infinite if they have no proper
    /// covariance.
    double same_wall_distance2(const std::vector<SameWall>& walls) const;
    /// Fuses each pair, all at once, and removes the lines that are gone.
    bool merge(const std::vector<SameWall>& walls);
    void remove(int id);

    /// Makes exactly these lines active; brings everything up to date.
    void activate(const std::vector<int>& ids);

    /// All numbers finite and all variances positive.
    bool is_sound() const;

 private:
    template <class Archive>
    friend void fields(Archive&, Ekf&);
    void predict_piece(const MotionPiece& piece);

    enum class Part { active, passive, gone };
    struct Slot {
        Part part;
        int position;  ///< within active_ or passive_
    };
    const Slot& slot(int id) const { return slots_[static_cast<std::size_t>(id)]; }
    static constexpr Eigen::Index head = 6;  ///< rows of the pose and of the wheel calibration
    static Eigen::Index row(int position) { return head + 2 * position; }
    /// Differences of the pairs, gone minus kept, and their H P H^T + slack.
    void same_wall_innovation(const std::vector<SameWall>& walls, Eigen::MatrixXd& PHt, Eigen::MatrixXd& S,
                              Eigen::VectorXd& v) const;
    /// x += P H^T S^-1 v and P -= P H^T S^-1 H P, for stacked rows: `PHt` and `H_phi` belong to the same H.
    bool apply(const Eigen::MatrixXd& PHt, const Eigen::MatrixXd& H_phi, const Eigen::MatrixXd& S,
               const Eigen::VectorXd& v);
    void bring_passive_up_to_date();
    void renumber();

    EkfParameters parameters_;
    Pose2 T_map_base_;
    WheelCalibration calibration_;
    std::vector<PlanarLine> lines_;  ///< by id
    std::vector<Slot> slots_;        ///< by id
    std::vector<int> active_, passive_;

    Eigen::Matrix3d motion_error_noise_ = Eigen::Matrix3d::Zero();
    Eigen::Matrix3d motion_error_covariance_ = Eigen::Matrix3d::Zero();
    Eigen::MatrixXd P_aa_;  ///< head and active lines, now
    Eigen::MatrixXd P_ab_;  ///< of them with passive lines, when the active set was chosen: rows as then
    Eigen::MatrixXd P_bb_;  ///< passive lines, then
    // Since then: P_ab(now) = phi P_ab, P_bb(now) = P_bb - P_ab^T psi P_ab, x_b(now) = x_b + P_ab^T chi.
    Eigen::MatrixXd phi_, psi_;
    Eigen::VectorXd chi_;
};

}  // namespace loopline::line_slam
