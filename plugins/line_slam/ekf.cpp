#include "line_slam/ekf.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace loopline::line_slam {
namespace {

/// A local map that mostly passes on lines from before to maps after it costs more than it saves.
constexpr std::size_t few_guests = 30;

}  // namespace

Ekf::Ekf(const EkfParameters& parameters) : parameters_(parameters) {
    LocalMap first;
    first.P = Eigen::MatrixXd::Zero(head, head);
    first.P.diagonal().segment<3>(3).setConstant(std::pow(parameters.drive.sigma_scale, 2));
    first.since_entered = {Eigen::MatrixXd(head, 0), Eigen::MatrixXd(0, 0),
                           Eigen::VectorXd(0)};  // nothing was before
    maps_.push_back(std::move(first));
}

Eigen::Matrix3d Ekf::pose_covariance() const {
    const Eigen::Matrix3d A = coordinates_from_error(pose_here());
    return A * P().topLeftCorner<3, 3>() * A.transpose();
}

Eigen::Matrix2d Ekf::line_covariance(int id) const {
    assert(is_active(id));
    return about_map_origin(id, origin_m(), P().block<2, 2>(row(id), row(id)));
}

Eigen::Matrix2d Ekf::about_map_origin(int id, const Eigen::Vector2d& origin_m,
                                      const Eigen::Matrix2d& covariance) const {
    Eigen::Matrix2d A;
    A << 1, turned_left(first_normal(id)).dot(origin_m), 0, 1;
    return A * covariance * A.transpose();
}

Eigen::Matrix3d Ekf::motion_error_covariance() const {
    Eigen::Matrix3d A = Eigen::Matrix3d::Identity();
    A.topRightCorner<2, 1>() = -turned_left(origin_m());
    return A * motion_error_covariance_ * A.transpose();
}

/// The paper's foot point is one from the map's own origin.
void Ekf::move_origin_here() {
    constexpr double near_m = 2;
    const Eigen::Vector2d here_m = T_map_base_.translation();
    if (parameters_.feature == Feature::foot_point || (here_m - origin_m()).norm() < near_m) return;
    local().move_origin(here_m, [this](int id) { return turned_left(first_normal(id)); });
}

Eigen::Matrix2d Ekf::predicted_covariance(int id_i, int id_j) const {
    assert(is_active(id_i) && is_active(id_j));
    const Eigen::Index i = row(id_i), j = row(id_j);
    const ObservationJacobians H_i =
        feature_jacobians(parameters_.feature, pose_here(), line_here(id_i), first_normal(id_i));
    const ObservationJacobians H_j =
        feature_jacobians(parameters_.feature, pose_here(), line_here(id_j), first_normal(id_j));
    const Matrix23 with_pose = H_i.pose * P().topLeftCorner<3, 3>() + H_i.line * P().block<2, 3>(i, 0);
    const Eigen::Matrix2d with_line = H_i.pose * P().block<3, 2>(0, j) + H_i.line * P().block<2, 2>(i, j);
    return with_pose * H_j.pose.transpose() + with_line * H_j.line.transpose();
}

void Ekf::predict(const std::vector<MotionPiece>& motion) {
    move_origin_here();
    motion_error_noise_.setZero();
    motion_error_covariance_.setZero();
    for (const MotionPiece& piece : motion) predict_piece(piece);
}

void Ekf::predict_piece(const MotionPiece& piece) {
    const WheelTravel& travel = piece.travel;
    Eigen::MatrixXd &P = local().P, &phi = local().since_entered.phi;
    const Pose2 T_old_new = moved(travel, parameters_.drive.track_width_m, calibration_);
    const MotionJacobians J = motion_jacobians(travel, parameters_.drive.track_width_m, calibration_);
    // A change of the increment's (x, y, phi) as an error on its left, and that as one on the new pose's
    // left.
    Eigen::Matrix3d from_coordinates = Eigen::Matrix3d::Identity();
    from_coordinates.topRightCorner<2, 1>() = -turned_left(T_old_new.translation());
    const Eigen::Matrix3d to_error = adjoint(pose_here()) * from_coordinates;
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
    motion_error_covariance_ += noise + F_calibration * P.block<3, 3>(3, 3) * F_calibration.transpose();

    P.topRows<3>() += F_calibration * P.middleRows<3>(3);
    P.leftCols<3>() += P.middleCols<3>(3) * F_calibration.transpose();
    P.topLeftCorner<3, 3>() += noise;
    phi.topRows<3>() += F_calibration * phi.middleRows<3>(3);
    T_map_base_ = T_map_base_ * T_old_new;
}

void Ekf::doubt_motion(double factor) {
    local().P.topLeftCorner<3, 3>() += factor * motion_error_noise_;
}

bool Ekf::update(const std::vector<Pairing>& pairings, const std::vector<LineObservation>& observations) {
    if (pairings.empty()) return true;
    const Eigen::MatrixXd& phi = maps_.back().since_entered.phi;
    const auto m = 2 * static_cast<Eigen::Index>(pairings.size());
    Eigen::MatrixXd PHt(P().rows(), m), H_phi(m, phi.cols()), S(m, m);
    Eigen::VectorXd v(m);
    std::vector<FeaturePrediction> f;
    for (std::size_t k = 0; k < pairings.size(); ++k) {
        const Eigen::Index at = 2 * static_cast<Eigen::Index>(k), r = row(pairings[k].line);
        const LineObservation& z = observations[static_cast<std::size_t>(pairings[k].observation)];
        f.push_back(predict_feature(parameters_.feature, pose_here(), line_here(pairings[k].line),
                                    first_normal(pairings[k].line), z, z.covariance + z.surplus));
        const ObservationJacobians& H = f[k].H;
        PHt.middleCols<2>(at) =
            P().leftCols<3>() * H.pose.transpose() + P().middleCols<2>(r) * H.line.transpose();
        H_phi.middleRows<2>(at) = H.pose * phi.topRows<3>() + H.line * phi.middleRows<2>(r);
        v.segment<2>(at) = f[k].innovation;
    }
    S.setZero();
    for (std::size_t k = 0; k < pairings.size(); ++k) {
        const Eigen::Index at = 2 * static_cast<Eigen::Index>(k), r = row(pairings[k].line);
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

    const Pose2 corrected_here = corrected(pose_here(), dx.head<3>());
    T_map_base_ = {corrected_here.x_m + origin_m().x(), corrected_here.y_m + origin_m().y(),
                   corrected_here.phi_rad};
    calibration_ = {calibration_.left + dx(3), calibration_.right + dx(4), calibration_.track + dx(5)};
    for (const int id : active_lines()) add_to_line(id, origin_m(), dx(row(id)), dx(row(id) + 1));
    local().P.noalias() -= W * W.transpose();
    auto& [phi, psi, chi] = local().since_entered;
    const Eigen::MatrixXd Y = llt.matrixL().solve(H_phi);
    phi.noalias() -= W * Y;
    psi.noalias() += Y.transpose() * Y;
    chi.noalias() += Y.transpose() * whitened;
    return true;
}

/// In terms of the line's distance from its own anchor, where what is of second order is small. The change of
/// that is linear in the errors, whatever origin they are about, so that it does not matter when a line is
/// told of it.
void Ekf::add_to_line(int id, const Eigen::Vector2d& origin_m, double rho_m, double alpha_rad) {
    PlanarLine& l = lines_[static_cast<std::size_t>(id)];
    const Eigen::Vector2d& anchor_m = anchors_m_[static_cast<std::size_t>(id)];
    const double lever_m = turned_left(first_normal(id)).dot(anchor_m - origin_m);
    const double rho_at_anchor_m = l.rho_m - l.normal().dot(anchor_m) + rho_m - lever_m * alpha_rad;
    l.alpha_rad = wrap_to_pi(l.alpha_rad + alpha_rad);
    l.rho_m = rho_at_anchor_m + l.normal().dot(anchor_m);
}

int Ekf::augment(const LineObservation& observation) {
    const PlanarLine l = transformed(T_map_base_, observation.line);
    const AugmentationJacobians G = augmentation_jacobians(pose_here(), l);
    Eigen::MatrixXd &P = local().P, &phi = local().since_entered.phi;
    const Eigen::Index n = P.rows();
    const Eigen::MatrixXd with_rest = G.pose * P.topRows<3>();
    P.conservativeResize(n + 2, n + 2);
    P.bottomLeftCorner(2, n) = with_rest;
    P.topRightCorner(n, 2) = with_rest.transpose();
    P.bottomRightCorner<2, 2>() =
        with_rest.leftCols<3>() * G.pose.transpose() +
        G.observation * (observation.covariance + observation.surplus) * G.observation.transpose();
    const Eigen::MatrixXd phi_new = G.pose * phi.topRows<3>();
    phi.conservativeResize(n + 2, Eigen::NoChange);
    phi.bottomRows<2>() = phi_new;

    const int id = line_ids();
    lines_.push_back(l);
    lines_on_leaving_.push_back(l);
    first_normals_.push_back(l.normal());
    anchors_m_.push_back(T_map_base_ * observation.middle_m());
    slots_.push_back({here(), static_cast<int>(active_lines().size())});
    local().lines.push_back(id);
    return id;
}

void Ekf::same_wall_innovation(const std::vector<SameWall>& walls, Eigen::MatrixXd& PHt, Eigen::MatrixXd& S,
                               Eigen::VectorXd& v) const {
    const auto m = 2 * static_cast<Eigen::Index>(walls.size());
    PHt.resize(P().rows(), m);
    S.resize(m, m);
    v.resize(m);
    for (Eigen::Index k = 0; k < m; k += 2) {
        const SameWall& w = walls[static_cast<std::size_t>(k / 2)];
        PHt.middleCols<2>(k) = P().middleCols<2>(row(w.kept)) - P().middleCols<2>(row(w.gone));
        v.segment<2>(k) = difference(line_here(w.gone), line_here(w.kept));
    }
    for (Eigen::Index k = 0; k < m; k += 2) {
        const SameWall& w = walls[static_cast<std::size_t>(k / 2)];
        S.middleRows<2>(k) = PHt.middleRows<2>(row(w.kept)) - PHt.middleRows<2>(row(w.gone));
        Eigen::Matrix2d to_here;
        to_here << 1, -line(w.kept).along_m(origin_m()), 0, 1;
        S.block<2, 2>(k, k) += to_here * w.slack * to_here.transpose();
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

/// Two lines that were first estimated in different directions answer differently to a motion of the whole
/// map. That they are one wall would then tell that motion, which nobody has seen. So the error of the one is
/// written anew, as if it had been estimated like the other: drho' = drho + (n' - n) . t.
void Ekf::turn_first_normal(int id, const Eigen::Vector2d& normal) {
    Eigen::MatrixXd &P = local().P, &phi = local().since_entered.phi;
    const Eigen::RowVector2d turn = (normal - first_normal(id)).transpose();
    P.row(row(id)) += turn * P.topRows<2>();
    P.col(row(id)) += P.leftCols<2>() * turn.transpose();
    phi.row(row(id)) += turn * phi.topRows<2>();
    first_normals_[static_cast<std::size_t>(id)] = normal;
}

bool Ekf::merge(const std::vector<SameWall>& walls) {
    for (const SameWall& w : walls) turn_first_normal(w.gone, first_normal(w.kept));
    Eigen::MatrixXd PHt, S;
    Eigen::VectorXd v;
    same_wall_innovation(walls, PHt, S, v);
    const Eigen::MatrixXd& phi = maps_.back().since_entered.phi;
    Eigen::MatrixXd H_phi(v.size(), phi.cols());
    for (std::size_t k = 0; k < walls.size(); ++k)
        H_phi.middleRows<2>(2 * static_cast<Eigen::Index>(k)) =
            phi.middleRows<2>(row(walls[k].kept)) - phi.middleRows<2>(row(walls[k].gone));
    if (!apply(PHt, H_phi, S, v)) return false;
    for (const SameWall& w : walls) remove(w.gone);
    return true;
}

void Ekf::remove(int id) {
    const Slot where = slot(id);
    assert(where.map != nowhere);
    maps_[static_cast<std::size_t>(where.map)].remove(where.position);
    slots_[static_cast<std::size_t>(id)].map = nowhere;
    number_lines(where.map);
}

void Ekf::number_lines(int map) {
    const std::vector<int>& ids = maps_[static_cast<std::size_t>(map)].lines;
    for (std::size_t k = 0; k < ids.size(); ++k) {
        Slot& s = slots_[static_cast<std::size_t>(ids[k])];
        if (s.map == map) s.position = static_cast<int>(k);
    }
}

std::vector<int> Ekf::at_home(int map) const {
    std::vector<int> ids;
    for (const int id : maps_[static_cast<std::size_t>(map)].lines)
        if (slot(id).map == map) ids.push_back(id);
    return ids;
}

void Ekf::activate(const std::vector<int>& ids) {
    std::vector<bool> wanted(slots_.size(), false);
    for (const int id : ids) wanted[static_cast<std::size_t>(id)] = true;
    std::vector<int> staying;
    for (const int id : active_lines())
        if (wanted[static_cast<std::size_t>(id)])
            staying.push_back(slot(id).position);
        else
            lines_on_leaving_[static_cast<std::size_t>(id)] = line(id);
    if (staying.size() < active_lines().size()) {
        maps_.push_back(local().leave(staying));
        for (const int id : active_lines()) slots_[static_cast<std::size_t>(id)].map = here();
        number_lines(here());
    }
    activate_also(ids);
}

void Ekf::activate_also(std::vector<int> ids) {
    ids.erase(std::remove_if(ids.begin(), ids.end(), [&](int id) { return is_active(id); }), ids.end());
    const auto home = [&](int a, int b) { return slot(a).map < slot(b).map; };
    const int first = ids.empty() ? here() - 1 : slot(*std::min_element(ids.begin(), ids.end(), home)).map;
    for (int map = first; map < here(); ++map) {
        std::vector<int> from_here;
        for (const int id : ids)
            if (slot(id).map == map) from_here.push_back(id);
        if (!from_here.empty()) send_on(map, from_here);
    }
    tidy(std::max(first, 0));
}

void Ekf::send_on(int map, const std::vector<int>& ids) {
    std::vector<int> positions;
    for (const int id : ids) positions.push_back(slot(id).position);
    LocalMap& next = maps_[static_cast<std::size_t>(map) + 1];
    LocalMap& home = maps_[static_cast<std::size_t>(map)];
    LocalMap::Guests guests = home.send_on(positions);
    for (const int id : ids)
        guests.lever_m.push_back(turned_left(first_normal(id)).dot(next.origin_m - home.origin_m));
    const auto change = next.welcome(guests);
    for (std::size_t k = 0; k < ids.size(); ++k) {
        const auto id = static_cast<std::size_t>(ids[k]);
        slots_[id].map = map + 1;
        lines_[id] = lines_on_leaving_[id];
        add_to_line(ids[k], home.origin_m, change(2 * static_cast<Eigen::Index>(k)),
                    change(2 * static_cast<Eigen::Index>(k) + 1));
        lines_on_leaving_[id] = lines_[id];
    }
    number_lines(map + 1);
}

/// A map that no line is at home in is a mere step of the chain, and one that carries many guests for few
/// lines of its own costs more than it saves: both are joined with the next. So a second round through
/// everything ends in one map, the full filter, instead of many that each hold nearly all.
void Ekf::tidy(int first_map) {
    for (int map = first_map; map < here();) {
        const std::size_t own = at_home(map).size();
        const std::size_t guests = maps_[static_cast<std::size_t>(map)].lines.size() - own;
        if (own == 0 || (guests > few_guests + 2 * own && map + 1 < here()))
            join_with_next(map);
        else
            ++map;
    }
}

void Ekf::join_with_next(int map) {
    const std::vector<int> own = at_home(map);
    if (!own.empty()) send_on(map, own);
    const auto k = static_cast<std::size_t>(map);
    maps_[k + 1].since_entered = joined(maps_[k], maps_[k + 1].since_entered);
    maps_.erase(maps_.begin() + map);
    for (Slot& s : slots_) s.map -= s.map > map;
}

void Ekf::refresh_passive_lines() {
    // chi of (1) from the entering of map k + 1 until now, in the terms of what map k kept.
    Eigen::VectorXd chi = local().since_entered.chi;
    for (int map = here() - 1; map >= 0; --map) {
        const LocalMap& m = maps_[static_cast<std::size_t>(map)];
        const auto kept = LocalMap::rows_of(m.kept);
        for (const int id : at_home(map)) {
            const Eigen::Vector2d change = m.P(kept, Eigen::seqN(row(id), 2)).transpose() * chi;
            lines_[static_cast<std::size_t>(id)] = lines_on_leaving_[static_cast<std::size_t>(id)];
            add_to_line(id, m.origin_m, change(0), change(1));
        }
        chi = m.since_entered.chi + m.since_entered.phi(kept, Eigen::all).transpose() * chi;
    }
}

std::vector<Eigen::Matrix2d> Ekf::line_covariances() const {
    std::vector<Eigen::Matrix2d> covariances(lines_.size(), Eigen::Matrix2d::Zero());
    for (const int id : active_lines()) covariances[static_cast<std::size_t>(id)] = line_covariance(id);
    Eigen::MatrixXd psi = maps_.back().since_entered.psi;  // as chi in refresh_passive_lines
    for (int map = here() - 1; map >= 0; --map) {
        const LocalMap& m = maps_[static_cast<std::size_t>(map)];
        const auto kept = LocalMap::rows_of(m.kept);
        for (const int id : at_home(map)) {
            const Eigen::MatrixXd with_kept = m.P(kept, Eigen::seqN(row(id), 2));
            covariances[static_cast<std::size_t>(id)] = about_map_origin(
                id, m.origin_m, m.P.block<2, 2>(row(id), row(id)) - with_kept.transpose() * psi * with_kept);
        }
        const Eigen::MatrixXd phi_kept = m.since_entered.phi(kept, Eigen::all);
        psi = (m.since_entered.psi + phi_kept.transpose() * psi * phi_kept).eval();
    }
    return covariances;
}

bool Ekf::is_sound() const {
    return P().allFinite() && std::isfinite(T_map_base_.x_m) && std::isfinite(T_map_base_.y_m) &&
           std::isfinite(T_map_base_.phi_rad) && (P().diagonal().tail(P().rows() - head).array() > 0).all() &&
           (P().diagonal().head<head>().array() >= 0).all();
}

}  // namespace loopline::line_slam
