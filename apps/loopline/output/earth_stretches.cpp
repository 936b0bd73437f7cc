#include "output/earth_stretches.h"

#include <cmath>

namespace loopline {
namespace {

/// Where the shorter way from a to b crosses the meridian, on the side of a.
EarthVertex crossing(const EarthVertex& a, const EarthVertex& b) {
    const double edge_deg = a.place.longitude_deg > 0 ? 180 : -180;
    const double b_deg = b.place.longitude_deg + 2 * edge_deg;  // counted on from a
    const double part = (edge_deg - a.place.longitude_deg) / (b_deg - a.place.longitude_deg);
    EarthVertex at = a;
    at.stamp_ns += std::llround(part * static_cast<double>(b.stamp_ns - a.stamp_ns));
    at.place.latitude_deg += part * (b.place.latitude_deg - a.place.latitude_deg);
    at.place.longitude_deg = edge_deg;
    at.place.height_m += part * (b.place.height_m - a.place.height_m);
    at.sigma_enu_m += part * (b.sigma_enu_m - a.sigma_enu_m);
    at.sigma_heading_rad += part * (b.sigma_heading_rad - a.sigma_heading_rad);
    return at;
}

}  // namespace

EarthStretches::EarthStretches(const Trajectory& trajectory, const gnss::GeoReference& reference,
                               Estimate estimate)
    : trajectory_(&trajectory), reference_(reference), estimate_(estimate) {
    const std::size_t first = estimate == Estimate::online ? trajectory.known_from() : 0;
    std::optional<EarthVertex> last;
    for (std::size_t i = first; i < trajectory.size(); ++i) {
        const auto here = vertex(i);
        if (!here) {
            ++left_out_;
            continue;
        }
        const bool crosses = last && std::abs(here->place.longitude_deg - last->place.longitude_deg) > 180;
        if (!last) stretches_.push_back({i, i, 0, {}, {}});
        if (crosses) {
            EarthVertex cut = crossing(*last, *here);
            stretches_.back().after = cut;
            cut.place.longitude_deg = -cut.place.longitude_deg;
            stretches_.push_back({i, i, 0, cut, {}});
        }
        stretches_.back().end = i + 1;
        ++stretches_.back().poses;
        last = here;
    }
}

std::optional<EarthVertex> EarthStretches::vertex(std::size_t index) const {
    const TrajectoryEntry entry = (*trajectory_)[index];
    const Pose3 pose =
        estimate_ == Estimate::latest ? entry.T_map_base : trajectory_->T_map_base_online(index);
    if (!pose.translation_m.allFinite()) return std::nullopt;
    const Eigen::Matrix3d& R = reference_.R_enu_map();
    const Eigen::Matrix3d covariance_enu =
        R * entry.covariance.matrix().topLeftCorner<3, 3>() * R.transpose();
    return EarthVertex{entry.stamp_ns, reference_.geodetic(pose.translation_m),
                       covariance_enu.diagonal().cwiseSqrt(), std::sqrt(entry.covariance(5, 5))};
}

std::size_t EarthStretches::vertices(std::size_t stretch) const {
    const Stretch& s = stretches_[stretch];
    return s.poses + (s.before ? 1 : 0) + (s.after ? 1 : 0);
}

void EarthStretches::for_each(std::size_t stretch, const Use& use) const {
    const Stretch& s = stretches_[stretch];
    if (s.before) use(*s.before);
    for (std::size_t i = s.first; i < s.end; ++i)
        if (const auto here = vertex(i)) use(*here);
    if (s.after) use(*s.after);
}

}  // namespace loopline
