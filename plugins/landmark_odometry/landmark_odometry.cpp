#include "landmark_odometry/landmark_odometry.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "inertial/pose_error.h"
#include "least_squares/chi_square.h"

namespace loopline::landmark_odometry {
namespace {

constexpr double tentative_sigma_m = 0.1;  // of the way between two sightings of what may become a landmark
constexpr std::int64_t tentative_scans = 10;  // without another sighting of it
constexpr double clearly_likelier = 6;  // in squares: a second landmark that fits worse by so much is none

struct Pair {
    std::size_t sighting = 0, landmark = 0;
};

struct Likeliest {
    Pair pair;
    double square = std::numeric_limits<double>::infinity();         ///< of its innovation
    double second_square = std::numeric_limits<double>::infinity();  ///< of the same sighting's next landmark
};

/// Of pairs in the order of sightings.
Likeliest likeliest(const LandmarkFilter& filter, const std::vector<Sighting>& sightings,
                    const std::vector<Pair>& pairs) {
    Likeliest best, of_sighting;
    for (std::size_t k = 0; k < pairs.size(); ++k) {
        if (k == 0 || pairs[k].sighting != pairs[k - 1].sighting) of_sighting = {};
        const double square = filter.innovation(pairs[k].landmark, sightings[pairs[k].sighting]).square();
        if (square < of_sighting.square)
            of_sighting = {pairs[k], square, of_sighting.square};
        else
            of_sighting.second_square = std::min(of_sighting.second_square, square);
        const bool is_last = k + 1 == pairs.size() || pairs[k + 1].sighting != pairs[k].sighting;
        if (is_last && of_sighting.square < best.square) best = of_sighting;
    }
    return best;
}

}  // namespace

void LandmarkOdometry::take(const Twist2& told, const std::vector<Sighting>& sightings) {
    ++scans_;
    filter_.move(told, settings_.motion);
    way_m_ += std::hypot(told.forward_m, told.left_m);
    const std::vector<Fate> fates = match(sightings);
    for (std::size_t k = 0; k < sightings.size(); ++k)
        if (fates[k] == Fate::open) consider_new(sightings[k]);
    forget();
    if (way_m_ - origin_way_m_ >= settings_.begin_anew_m) begin_anew();
}

/// The likeliest pair first; it makes the pose better by which the others are judged.
std::vector<LandmarkOdometry::Fate> LandmarkOdometry::match(const std::vector<Sighting>& sightings) {
    const double gate = least_squares::chi_square_quantile(2, settings_.gate);
    constexpr double in_question = 4;  // times the gate: an update may yet draw it in
    std::vector<Pair> pairs;
    for (std::size_t s = 0; s < sightings.size(); ++s)
        for (std::size_t m = 0; m < filter_.landmarks(); ++m)
            if (filter_.innovation(m, sightings[s]).square() < in_question * gate) pairs.push_back({s, m});

    std::vector<Fate> fates(sightings.size(), Fate::open);
    const auto leave_out = [&pairs](const auto& is_out) {
        pairs.erase(std::remove_if(pairs.begin(), pairs.end(), is_out), pairs.end());
    };
    while (!pairs.empty()) {
        const Likeliest best = likeliest(filter_, sightings, pairs);
        const auto [s, m] = best.pair;
        if (best.square > gate) break;
        const bool is_clear = best.second_square > best.square + clearly_likelier;
        fates[s] = is_clear ? Fate::matched : Fate::ambiguous;
        ++(is_clear ? counts_.matched : counts_.ambiguous);
        leave_out([&, of = s](const Pair& pair) { return pair.sighting == of; });
        if (!is_clear) continue;
        filter_.update(m, filter_.innovation(m, sightings[s]));
        seen_[m].way_m = way_m_;
        counts_.sum_of_squares += best.square;
        leave_out([&, of = m](const Pair& pair) { return pair.landmark == of; });
    }
    return fates;
}

bool LandmarkOdometry::is_near_landmark(const Sighting& sighting) const {
    const Eigen::Vector2d p_local_m = filter_.T_local_base() * sighting.p_base_m;
    for (std::size_t m = 0; m < filter_.landmarks(); ++m)
        if ((filter_.p_local_m(m) - p_local_m).norm() < settings_.new_beyond_m) return true;
    return false;
}

/// A landmark is what was seen in several scans at one place: no leaf, no passer-by.
void LandmarkOdometry::consider_new(const Sighting& sighting) {
    if (is_near_landmark(sighting)) {
        ++counts_.off;
        return;
    }
    ++counts_.tentative;
    const Pose2 T_local_base = filter_.T_local_base();
    const Eigen::Vector2d p_local_m = T_local_base * sighting.p_base_m;
    const Eigen::Matrix2d R_local_base = Eigen::Rotation2Dd(T_local_base.phi_rad).toRotationMatrix(),
                          covariance_m2 = R_local_base * sighting.covariance_m2 * R_local_base.transpose();
    const double gate = least_squares::chi_square_quantile(2, settings_.gate);
    const auto is_it = [&](const Tentative& t) {
        const Eigen::Vector2d off_m = p_local_m - t.p_local_m;
        const Eigen::Matrix2d S = t.covariance_m2 + covariance_m2 +
                                  tentative_sigma_m * tentative_sigma_m * Eigen::Matrix2d::Identity();
        return t.scan < scans_ && off_m.dot(S.llt().solve(off_m)) < gate;
    };
    auto found = std::find_if(tentative_.begin(), tentative_.end(), is_it);
    if (found == tentative_.end()) found = tentative_.insert(found, {p_local_m, covariance_m2});
    found->scan = scans_;
    if (++found->sightings < settings_.sightings_of_new) return;
    tentative_.erase(found);
    filter_.add(sighting);
    seen_.push_back({way_m_});
    ++counts_.landmarks;
}

void LandmarkOdometry::forget() {
    for (std::size_t m = seen_.size(); m-- > 0;)
        if (way_m_ - seen_[m].way_m > settings_.remember_m) {
            filter_.remove(m);
            seen_.erase(seen_.begin() + static_cast<std::ptrdiff_t>(m));
        }
    tentative_.erase(std::remove_if(tentative_.begin(), tentative_.end(),
                                    [this](const Tentative& t) { return scans_ - t.scan > tentative_scans; }),
                     tentative_.end());
}

PoseWithCovariance LandmarkOdometry::pose() const {
    PoseWithCovariance pose;
    pose.T_map_base = origin_.T_map_base * Pose3(filter_.T_local_base());
    pose.covariance = inertial::grown(origin_.covariance, origin_.T_map_base, pose.T_map_base,
                                      in_space(filter_.pose_covariance(), way_m_ - origin_way_m_));
    return pose;
}

void LandmarkOdometry::begin_anew() {
    const Pose2 T_base_local = filter_.T_local_base().inverse();
    origin_ = pose();
    origin_way_m_ = way_m_;
    const Eigen::Matrix2d R_base_local = Eigen::Rotation2Dd(T_base_local.phi_rad).toRotationMatrix();
    for (Tentative& tentative : tentative_) {
        tentative.p_local_m = T_base_local * tentative.p_local_m;
        tentative.covariance_m2 = R_base_local * tentative.covariance_m2 * R_base_local.transpose();
    }
    filter_.begin_anew();
}

Matrix6d LandmarkOdometry::in_space(const Eigen::Matrix3d& covariance, double way_m) const {
    Matrix6d of_motion = Matrix6d::Zero();
    constexpr Eigen::Index in_plane[] = {0, 1, 5};
    for (Eigen::Index i = 0; i < 3; ++i)
        for (Eigen::Index j = 0; j < 3; ++j) of_motion(in_plane[i], in_plane[j]) = covariance(i, j);
    of_motion(2, 2) = settings_.up_m * settings_.up_m * way_m;
    of_motion(3, 3) = of_motion(4, 4) = settings_.tilt_rad * settings_.tilt_rad * way_m;
    return of_motion;
}

}  // namespace loopline::landmark_odometry
