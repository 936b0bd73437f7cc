#include "gnss/utm_of_map.h"

#include <cmath>

namespace loopline::gnss {
namespace {

constexpr double side_m = 256, half_m = side_m / 2;
constexpr std::size_t most_cells = 4096;  // memory does not grow with the map

}  // namespace

Eigen::Vector3d UtmOfMap::exact_p_utm_m(const Eigen::Vector3d& p_map_m) const {
    const Geodetic place = reference_.geodetic(p_map_m);
    const Utm utm = to_utm(place, grid_.zone, grid_.north);
    return {utm.easting_m, utm.northing_m, place.height_m};
}

UtmOfMap::Cell UtmOfMap::cell_about(const Eigen::Vector3d& middle_m) const {
    Cell cell;
    cell.middle_m = middle_m;
    const auto at = [&](const Eigen::Vector3d& d_m) { return exact_p_utm_m(middle_m + d_m); };
    const auto set = [&cell](int i, int k, const Eigen::Vector3d& second) {
        for (std::size_t f = 0; f < 3; ++f)
            cell.curvature[f](i, k) = cell.curvature[f](k, i) = second[static_cast<int>(f)];
    };
    const Eigen::Matrix3d step = half_m * Eigen::Matrix3d::Identity();
    cell.at_middle_m = at(Eigen::Vector3d::Zero());
    for (int i = 0; i < 3; ++i) {
        const Eigen::Vector3d ahead = at(step.col(i)), behind = at(-step.col(i));
        cell.slope.col(i) = (ahead - behind) / side_m;
        set(i, i, (ahead - 2 * cell.at_middle_m + behind) / (half_m * half_m));
        for (int k = 0; k < i; ++k)
            set(i, k,
                (at(step.col(i) + step.col(k)) - at(step.col(i) - step.col(k)) -
                 at(step.col(k) - step.col(i)) + at(-step.col(i) - step.col(k))) /
                    (side_m * side_m));
    }
    return cell;
}

Eigen::Vector3d UtmOfMap::p_utm_m(const Eigen::Vector3d& p_map_m) {
    Key key;
    for (std::size_t i = 0; i < 3; ++i)
        key[i] = static_cast<std::int32_t>(std::floor(p_map_m[static_cast<int>(i)] / side_m));
    if (last_ == nullptr || key != last_key_) {
        if (cells_.size() >= most_cells) cells_.clear();
        auto found = cells_.find(key);
        if (found == cells_.end())
            found = cells_
                        .emplace(key,
                                 cell_about(side_m *
                                            (Eigen::Vector3d(key[0], key[1], key[2]).array() + 0.5).matrix()))
                        .first;
        last_ = &found->second;
        last_key_ = key;
    }
    const Cell& cell = *last_;
    const Eigen::Vector3d d_m = p_map_m - cell.middle_m;
    Eigen::Vector3d p_utm_m = cell.at_middle_m + cell.slope * d_m;
    for (std::size_t f = 0; f < 3; ++f)
        p_utm_m[static_cast<int>(f)] += 0.5 * d_m.dot(cell.curvature[f] * d_m);
    return p_utm_m;
}

}  // namespace loopline::gnss
