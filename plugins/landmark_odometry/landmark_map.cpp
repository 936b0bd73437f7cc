#include "landmark_odometry/landmark_map.h"

#include <Eigen/Cholesky>
#include <cmath>

namespace loopline::landmark_odometry {

Eigen::Vector2d LandmarkMap::Sum::mean() const {
    return information.llt().solve(weighted);
}

LandmarkMap::Cell LandmarkMap::cell_of(const Eigen::Vector2d& p_map_m) const {
    return {static_cast<int>(std::floor(p_map_m.x() / join_m_)),
            static_cast<int>(std::floor(p_map_m.y() / join_m_))};
}

void LandmarkMap::add(const Eigen::Vector2d& p_map_m, const Eigen::Matrix2d& covariance_m2) {
    constexpr double limit_m = 1e6;
    if (!(p_map_m.cwiseAbs().maxCoeff() < limit_m)) return;
    const Cell cell = cell_of(p_map_m);
    double nearest_m = join_m_;
    std::size_t of = sums_.size();
    // A mean may have left the cell of its first sighting by one.
    for (int x = cell.first - 2; x <= cell.first + 2; ++x)
        for (int y = cell.second - 2; y <= cell.second + 2; ++y) {
            const auto found = begun_in_.find({x, y});
            if (found == begun_in_.end()) continue;
            for (const std::size_t k : found->second)
                if (const double off_m = (sums_[k].mean() - p_map_m).norm(); off_m < nearest_m) {
                    nearest_m = off_m;
                    of = k;
                }
        }
    if (of == sums_.size()) {
        sums_.emplace_back();
        begun_in_[cell].push_back(of);
    }
    const Eigen::Matrix2d information = covariance_m2.inverse();
    sums_[of].information += information;
    sums_[of].weighted += information * p_map_m;
    ++sums_[of].sightings;
}

std::vector<MappedLandmark> LandmarkMap::landmarks(int least_sightings) const {
    std::vector<Sum> joined;
    for (const Sum& sum : sums_) {
        Sum* same = nullptr;
        for (Sum& other : joined)
            if ((other.mean() - sum.mean()).norm() < join_m_) {
                same = &other;
                break;
            }
        if (same == nullptr) {
            joined.push_back(sum);
            continue;
        }
        same->information += sum.information;
        same->weighted += sum.weighted;
        same->sightings += sum.sightings;
    }
    std::vector<MappedLandmark> landmarks;
    for (const Sum& sum : joined)
        if (sum.sightings >= least_sightings) landmarks.push_back({sum.mean(), sum.sightings});
    return landmarks;
}

}  // namespace loopline::landmark_odometry
