#include "line_slam/ekf.h"

#include <Eigen/Cholesky>
#include <cassert>
#include <cmath>
#include <limits>

namespace loopline::line_slam {
namespace {

/// `matrix` without rows (and columns, if `both`) first .. first + count - 1.
Eigen::MatrixXd without(const Eigen::MatrixXd& matrix, Eigen::Index first, Eigen::Index count, bool both) {
    const Eigen::Index rows = matrix.rows() - count, cols = matrix.cols() - (both ? count : 0);
    Eigen::MatrixXd rest(rows, cols);
    for (Eigen::Index c = 0; c < cols; ++c) {
        const Eigen::Index from = both && c >= first ? c + count : c;
        rest.col(c).head(first) = matrix.col(from).head(first);
        rest.col(c).tail(rows - first) = matrix.col(from).tail(rows - first);
    }
    return rest;
}

}  // namespace

Ekf::Ekf(const EkfParameters& parameters)
    : parameters_(parameters),
      P_aa_(Eigen::MatrixXd::Zero(head, head)),
      P_ab_(head, 0),
      P_bb_(0, 0),
      phi_(Eigen::MatrixXd::Identity(head, head)),
      psi_(Eigen::MatrixXd::Zero(head, head)),
      chi_(Eigen::VectorXd::Zero(head)) {
    P_aa_.diagonal().segment<3>(3).setConstant(std::pow(parameters.drive.sigma_scale, 2));
}

Eigen::Matrix3d Ekf::pose_covariance() const {
    const Eigen::Matrix3d A = coordinates_from_error(T_map_base_);
    return A * pose_error_covariance() * A.transpose();
}

Eigen::Matrix2d Ekf::line_covariance(int id) const {
    assert(is_active(id));
    const Eigen::Index r = row(slot(id).position);
    return P_aa_.block<2, 2>(r, r);
}

Eigen::Matrix2d Ekf::predicted_covariance(int id_i, int id_j) const {
    assert(is_active(id_i) && is_active(id_j));
    const Eigen::Index i = row(slot(id_i).position), j = row(slot(id_j).position);
    const ObservationJacobians H_i = feature_jacobians(parameters_.feature, T_map_base_, line(id_i));
    const ObservationJacobians H_j = feature_jacobians(parameters_.feature, T_map_base_, line(id_j));
    const Matrix23 with_pose = H_i.pose * P_aa_.topLeftCorner<3, 3>() + H_i.line * P_aa_.block<2, 3>(i, 0);
    const Eigen::Matrix2d with_line = H_i.pose * P_aa_.block<3, 2>(0, j) + H_i.line * P_aa_.block<2, 2>(i, j);
    return with_pose * H_j.pose.transpose() + with_line * H_j.line.transpose();
}

void Ekf::predict(const std::vector<MotionPiece>& motion) {
    motion_error_noise_.setZero();
    motion_error_covariance_.setZero();
    for (const MotionPiece& piece : motion) predict_piece(piece);
}

void Ekf::predict_piece(const MotionPiece& piece) {
    const WheelTravel& travel = piece.travel;
    const Pose2 T_old_new = moved(travel, parameters_.drive.track_width_m, calibration_);
    const MotionJacobians J = motion_jacobians(travel, parameters_.drive.track_width_m, calibration_);
    // A change of the increment's (x, y, phi) as an error on its left, and that as one on the new pose's
    // left.
    Eigen::Matrix3d from_coordinates = Eigen::Matrix3d::Identity();
    from_coordinates.topRightCorner<2, 1>() = -turned_left(T_old_new.translation());
    const Eigen::Matrix3d to_error = adjoint(T_map_base_) * from_coordinates;
    const Eigen::Matrix3d& Q = piece.covariance;
    // Only a turn that stands out of its noise tells of the track width; noise taken for a turn would teach a
    // wrong one.
    const double turn_m = travel.right_m - travel.left_m;
    const double signal = std::pow(turn_m, 4), chance = std::pow(9 * (Q(0, 0) + Q(1, 1)), 2);
    const Eigen::Vector3d credible(1, 1, signal / (signal + chance));
    const Eigen::Matrix3d F_calibration = to_error * J.calibration * credible.asDiagonal();
    const Eigen::Matrix3d G = to_error * J.travel;
    const Eigen::Matrix3d noise = G * Q * G.transpose();
    motion_error_noise_ += noise;
    motion_error_covariance_ += noise + F_calibration * P_aa_.block<3, 3>(3, 3) * F_calibration.transpose();

    P_aa_.topRows<3>() += F_calibration * P_aa_.middleRows<3>(3);
    P_aa_.leftCols<3>() += P_aa_.middleCols<3>(3) * F_calibration.transpose();
    P_aa_.topLeftCorner<3, 3>() += noise;
    phi_.topRows<3>() += F_calibration * phi_.middleRows<3>(3);
    T_map_base_ = T_map_base_ * T_old_new;
}

void Ekf::doubt_motion(double factor) {
    P_aa_.topLeftCorner<3, 3>() += factor * motion_error_noise_;
}

bool Ekf::update(const std::vector<Pairing>& pairings, const std::vector<LineObservation>& observations) {
    if (pairings.empty()) return true;
    const auto m = 2 * static_cast<Eigen::Index>(pairings.size());
    Eigen::MatrixXd PHt(P_aa_.rows(), m), H_phi(m, phi_.cols()), S(m, m);
    Eigen::VectorXd v(m);
    std::vector<FeaturePrediction> f;
    for (std::size_t k = 0; k < pairings.size(); ++k) {
        const Eigen::Index at = 2 * static_cast<Eigen::Index>(k), r = row(slot(pairings[k].line).position);
        const LineObservation& z = observations[static_cast<std::size_t>(pairings[k].observation)];
        f.push_back(predict_feature(parameters_.feature, T_map_base_, line(pairings[k].line), z,
                                    z.covariance + z.surplus));
        const ObservationJacobians& H = f[k].H;
        PHt.middleCols<2>(at) =
            P_aa_.leftCols<3>() * H.pose.transpose() + P_aa_.middleCols<2>(r) * H.line.transpose();
        H_phi.middleRows<2>(at) = H.pose * phi_.topRows<3>() + H.line * phi_.middleRows<2>(r);
        v.segment<2>(at) = f[k].innovation;
    }
    S.setZero();
    for (std::size_t k = 0; k < pairings.size(); ++k) {
        const Eigen::Index at = 2 * static_cast<Eigen::Index>(k), r = row(slot(pairings[k].line).position);
        const ObservationJacobians& H = f[k].H;
        if (parameters_.update == Update::joint)
            S.middleRows<2>(at) = H.pose * PHt.topRows<3>() + H.line * PHt.middleRows<2>(r);
        else
            S.block<2, 2>(at, at) = H.pose * PHt.block<3, 2>(0, at) + H.line * PHt.block<2, 2>(r, at);
        S.block<2, 2>(at, at) += f[k].noise;
    }
    return apply(PHt, H_phi, S, v);
}

bool Ekf::apply(const Eigen::MatrixXd& PHt, const Eigen::MatrixXd& H_phi, const Eigen::MatrixXd& S,
                const Eigen::VectorXd& v) {
    const Eigen::LLT<Eigen::MatrixXd> llt(S);
    if (llt.info() != Eigen::Success || !S.allFinite() || !v.allFinite()) return false;
    // W W^T = K S K^T: symmetric whatever the rounding.
    const Eigen::MatrixXd W = llt.matrixL().solve(PHt.transpose()).transpose();
    const Eigen::VectorXd whitened = llt.matrixL().solve(v);
    const Eigen::VectorXd dx = W * whitened;
    if (!dx.allFinite()) return false;

    T_map_base_ = corrected(T_map_base_, dx.head<3>());
    calibration_ = {calibration_.left + dx(3), calibration_.right + dx(4), calibration_.track + dx(5)};
    for (std::size_t k = 0; k < active_.size(); ++k) {
        PlanarLine& l = lines_[static_cast<std::size_t>(active_[k])];
        l.rho_m += dx(row(static_cast<int>(k)));
        l.alpha_rad = wrap_to_pi(l.alpha_rad + dx(row(static_cast<int>(k)) + 1));
    }
    P_aa_.noalias() -= W * W.transpose();
    if (!passive_.empty()) {
        const Eigen::MatrixXd Y = llt.matrixL().solve(H_phi);
        phi_.noalias() -= W * Y;
        psi_.noalias() += Y.transpose() * Y;
        chi_.noalias() += Y.transpose() * whitened;
    }
    return true;
}

int Ekf::augment(const LineObservation& observation) {
    const PlanarLine l = transformed(T_map_base_, observation.line);
    const AugmentationJacobians G = augmentation_jacobians(T_map_base_, l);
    const Eigen::Index n = P_aa_.rows();
    const Eigen::MatrixXd with_rest = G.pose * P_aa_.topRows<3>();
    P_aa_.conservativeResize(n + 2, n + 2);
    P_aa_.bottomLeftCorner(2, n) = with_rest;
    P_aa_.topRightCorner(n, 2) = with_rest.transpose();
    P_aa_.bottomRightCorner<2, 2>() =
        with_rest.leftCols<3>() * G.pose.transpose() +
        G.observation * (observation.covariance + observation.surplus) * G.observation.transpose();
    const Eigen::MatrixXd phi_new = G.pose * phi_.topRows<3>();
    phi_.conservativeResize(n + 2, Eigen::NoChange);
    phi_.bottomRows<2>() = phi_new;

    const int id = line_ids();
    lines_.push_back(l);
    slots_.push_back({Part::active, static_cast<int>(active_.size())});
    active_.push_back(id);
    return id;
}

void Ekf::same_wall_innovation(const std::vector<SameWall>& walls, Eigen::MatrixXd& PHt, Eigen::MatrixXd& S,
                               Eigen::VectorXd& v) const {
    const auto m = 2 * static_cast<Eigen::Index>(walls.size());
    PHt.resize(P_aa_.rows(), m);
    S.resize(m, m);
    v.resize(m);
    for (Eigen::Index k = 0; k < m; k += 2) {
        const SameWall& w = walls[static_cast<std::size_t>(k / 2)];
        PHt.middleCols<2>(k) =
            P_aa_.middleCols<2>(row(slot(w.kept).position)) - P_aa_.middleCols<2>(row(slot(w.gone).position));
        v.segment<2>(k) << line(w.gone).rho_m - line(w.kept).rho_m,
            wrap_to_pi(line(w.gone).alpha_rad - line(w.kept).alpha_rad);
    }
    for (Eigen::Index k = 0; k < m; k += 2) {
        const SameWall& w = walls[static_cast<std::size_t>(k / 2)];
        S.middleRows<2>(k) =
            PHt.middleRows<2>(row(slot(w.kept).position)) - PHt.middleRows<2>(row(slot(w.gone).position));
        S.block<2, 2>(k, k) += w.slack;
    }
}

double Ekf::same_wall_distance2(const std::vector<SameWall>& walls) const {
    Eigen::MatrixXd PHt, S;
    Eigen::VectorXd v;
    same_wall_innovation(walls, PHt, S, v);
    const Eigen::LLT<Eigen::MatrixXd> llt(S);
    if (llt.info() != Eigen::Success) return std::numeric_limits<double>::infinity();
    return llt.matrixL().solve(v).squaredNorm();
}

bool Ekf::merge(const std::vector<SameWall>& walls) {
    Eigen::MatrixXd PHt, S;
    Eigen::VectorXd v;
    same_wall_innovation(walls, PHt, S, v);
    Eigen::MatrixXd H_phi(v.size(), phi_.cols());
    for (std::size_t k = 0; k < walls.size(); ++k)
        H_phi.middleRows<2>(2 * static_cast<Eigen::Index>(k)) =
            phi_.middleRows<2>(row(slot(walls[k].kept).position)) -
            phi_.middleRows<2>(row(slot(walls[k].gone).position));
    if (!apply(PHt, H_phi, S, v)) return false;
    for (const SameWall& w : walls) remove(w.gone);
    return true;
}

void Ekf::remove(int id) {
    const Slot where = slot(id);
    assert(where.part != Part::gone);
    const Eigen::Index first = 2 * where.position;
    if (where.part == Part::active) {
        P_aa_ = without(P_aa_, head + first, 2, true);
        phi_ = without(phi_, head + first, 2, false);
        active_.erase(active_.begin() + where.position);
    } else {
        P_ab_ = without(P_ab_.transpose(), first, 2, false).transpose().eval();
        P_bb_ = without(P_bb_, first, 2, true);
        passive_.erase(passive_.begin() + where.position);
    }
    slots_[static_cast<std::size_t>(id)] = {Part::gone, 0};
    renumber();
}

void Ekf::bring_passive_up_to_date() {
    const Eigen::MatrixXd psi_P_ab = psi_ * P_ab_;
    P_bb_.noalias() -= P_ab_.transpose() * psi_P_ab;
    const Eigen::VectorXd dx = P_ab_.transpose() * chi_;
    for (std::size_t k = 0; k < passive_.size(); ++k) {
        PlanarLine& l = lines_[static_cast<std::size_t>(passive_[k])];
        l.rho_m += dx(2 * static_cast<Eigen::Index>(k));
        l.alpha_rad = wrap_to_pi(l.alpha_rad + dx(2 * static_cast<Eigen::Index>(k) + 1));
    }
    P_ab_ = (phi_ * P_ab_).eval();
}

void Ekf::activate(const std::vector<int>& ids) {
    bring_passive_up_to_date();
    const Eigen::Index a = P_aa_.rows(), b = P_bb_.rows();
    Eigen::MatrixXd P(a + b, a + b);
    P << P_aa_, P_ab_, P_ab_.transpose(), P_bb_;

    std::vector<int> rest;
    std::vector<bool> wanted(slots_.size(), false);
    for (const int id : ids) wanted[static_cast<std::size_t>(id)] = true;
    for (int id = 0; id < line_ids(); ++id)
        if (exists(id) && !wanted[static_cast<std::size_t>(id)]) rest.push_back(id);
    std::vector<Eigen::Index> source{0, 1, 2, 3, 4, 5};
    for (const std::vector<int>* part : std::initializer_list<const std::vector<int>*>{&ids, &rest})
        for (const int id : *part) {
            const Eigen::Index r = is_active(id) ? row(slot(id).position) : a + 2 * slot(id).position;
            source.insert(source.end(), {r, r + 1});
        }
    const Eigen::Index a_new = head + 2 * static_cast<Eigen::Index>(ids.size());
    P = P(source, source).eval();
    P_aa_ = P.topLeftCorner(a_new, a_new);
    P_ab_ = P.topRightCorner(a_new, a + b - a_new);
    P_bb_ = P.bottomRightCorner(a + b - a_new, a + b - a_new);
    active_ = ids;
    passive_ = rest;
    renumber();
    phi_ = Eigen::MatrixXd::Identity(a_new, a_new);
    psi_ = Eigen::MatrixXd::Zero(a_new, a_new);
    chi_ = Eigen::VectorXd::Zero(a_new);
}

void Ekf::renumber() {
    for (std::size_t k = 0; k < active_.size(); ++k)
        slots_[static_cast<std::size_t>(active_[k])] = {Part::active, static_cast<int>(k)};
    for (std::size_t k = 0; k < passive_.size(); ++k)
        slots_[static_cast<std::size_t>(passive_[k])] = {Part::passive, static_cast<int>(k)};
}

bool Ekf::is_sound() const {
    return P_aa_.allFinite() && std::isfinite(T_map_base_.x_m) && std::isfinite(T_map_base_.y_m) &&
           std::isfinite(T_map_base_.phi_rad) &&
           (P_aa_.diagonal().tail(P_aa_.rows() - head).array() > 0).all() &&
           (P_aa_.diagonal().head<head>().array() >= 0).all();
}

}  // namespace loopline::line_slam
