/// The state (pose, wheel calibration and map lines), its covariance, and everything that changes them.
///
/// Lines near the vehicle are active; the others are passive. Prediction, update and augmentation touch the
/// active part alone, which is the last of a chain of local maps (local_map.h); the others are told what they
/// have to learn from it when they are looked at: exactly the full filter's result, at a cost per scan that
/// does not grow with the map.
///
/// Errors are those of line_observation.h: invariant for the pose, plain (rho, alpha) for lines. So the
/// motion model's pose Jacobian, eq. (5), is the identity, and eq. (6) leaves the cross covariance alone.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "line_slam/feature.h"
#include "line_slam/local_map.h"
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
    /// A passive line's value may lag behind until it is activated, or all are refreshed.
    const PlanarLine& line(int id) const { return lines_[static_cast<std::size_t>(id)]; }
    bool is_active(int id) const { return slot(id).map == here(); }
    bool exists(int id) const { return slot(id).map != nowhere; }
    const std::vector<int>& active_lines() const { return maps_.back().lines; }
    /// Ids that were ever given: 0 .. line_ids() - 1.
    int line_ids() const { return static_cast<int>(lines_.size()); }

    /// Covariance of the pose's (x, y, phi).
    Eigen::Matrix3d pose_covariance() const;
    /// Covariance of an active line's (rho, alpha).
    Eigen::Matrix2d line_covariance(int id) const;
    /// H_i P H_j^T of two active lines' observations, eq. (12) without R.
    Eigen::Matrix2d predicted_covariance(int id_i, int id_j) const;
    /// v of eq. (13), and its R, of one sighting by itself.
    FeaturePrediction prediction(int id, const LineObservation& observation) const {
        return predict_feature(parameters_.feature, pose_here(), line_here(id), first_normal(id), observation,
                               observation.covariance);
    }

    /// Eq. (3)-(6), piece by piece.
    void predict(const std::vector<MotionPiece>& motion);
    /// The same for one piece with the drive's own noise.
    void predict(const WheelTravel& travel) {
        predict({MotionPiece{travel, travel_covariance(travel, parameters_.drive)}});
    }

    /// What the last motion added to the pose's error about the map's origin: noise and calibration.
    Eigen::Matrix3d motion_error_covariance() const;
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

    /// Makes exactly these lines active, and these alone up to date.
    void activate(const std::vector<int>& ids);
    /// Makes these active too.
    void activate_also(std::vector<int> ids);
    /// The values of passive lines as they are known now.
    void refresh_passive_lines();
    /// Covariances of (rho, alpha) of all lines, by id; zero of those that do not exist.
    std::vector<Eigen::Matrix2d> line_covariances() const;

    std::size_t local_maps() const { return maps_.size(); }

    /// All numbers finite and all variances positive.
    bool is_sound() const;

 private:
    template <class Archive>
    friend void fields(Archive&, Ekf&);
    void predict_piece(const MotionPiece& piece);
    void move_origin_here();
    /// Pose and line about the origin of the active local map, as all errors are.
    const Eigen::Vector2d& origin_m() const { return maps_.back().origin_m; }
    Pose2 pose_here() const {
        return {T_map_base_.x_m - origin_m().x(), T_map_base_.y_m - origin_m().y(), T_map_base_.phi_rad};
    }
    PlanarLine line_here(int id) const {
        return {line(id).rho_m - line(id).normal().dot(origin_m()), line(id).alpha_rad};
    }
    /// A covariance of (rho, alpha) about `origin_m`, about the map's origin.
    Eigen::Matrix2d about_map_origin(int id, const Eigen::Vector2d& origin_m,
                                     const Eigen::Matrix2d& covariance) const;

    static constexpr Eigen::Index head = LocalMap::head;
    static constexpr int nowhere = -1;
    /// Where a line is at home: in the last local map that holds it.
    struct Slot {
        int map;
        int position;  ///< within its lines
    };
    const Slot& slot(int id) const { return slots_[static_cast<std::size_t>(id)]; }
    int here() const { return static_cast<int>(maps_.size()) - 1; }
    LocalMap& local() { return maps_.back(); }
    const Eigen::MatrixXd& P() const { return maps_.back().P; }
    Eigen::Index row(int id) const { return LocalMap::row(slot(id).position); }

    /// Differences of the pairs, gone minus kept, and their H P H^T + slack.
    void same_wall_innovation(const std::vector<SameWall>& walls, Eigen::MatrixXd& PHt, Eigen::MatrixXd& S,
                              Eigen::VectorXd& v) const;
    /// x += P H^T S^-1 v and P -= P H^T S^-1 H P, for stacked rows: `PHt` and `H_phi` belong to the same H.
    bool apply(const Eigen::MatrixXd& PHt, const Eigen::MatrixXd& H_phi, const Eigen::MatrixXd& S,
               const Eigen::VectorXd& v);
    const Eigen::Vector2d& first_normal(int id) const { return first_normals_[static_cast<std::size_t>(id)]; }
    void turn_first_normal(int id, const Eigen::Vector2d& normal);
    /// A change of (rho, alpha) about `origin_m`.
    void add_to_line(int id, const Eigen::Vector2d& origin_m, double rho_m, double alpha_rad);
    /// Lines that are at home in `map` move on to the next one.
    void send_on(int map, const std::vector<int>& ids);
    std::vector<int> at_home(int map) const;
    /// Keeps the chain short: see the function.
    void tidy(int first_map);
    void join_with_next(int map);
    void number_lines(int map);

    EkfParameters parameters_;
    Pose2 T_map_base_;
    WheelCalibration calibration_;
    std::vector<PlanarLine> lines_;               ///< by id
    std::vector<PlanarLine> lines_on_leaving_;    ///< by id: as the line was when its home was left
    std::vector<Eigen::Vector2d> first_normals_;  ///< by id: for all Jacobians, see line_observation.h
    std::vector<Eigen::Vector2d>
        anchors_m_;               ///< by id: a place on the line where it was first seen, map frame
    std::vector<Slot> slots_;     ///< by id
    std::vector<LocalMap> maps_;  ///< the last is the active one

    Eigen::Matrix3d motion_error_noise_ = Eigen::Matrix3d::Zero();
    Eigen::Matrix3d motion_error_covariance_ = Eigen::Matrix3d::Zero();
};

}  // namespace loopline::line_slam
