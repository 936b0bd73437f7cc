#include "cloud_localisation/sweep_from_above.h"

#include <Eigen/Cholesky>
#include <algorithm>

namespace loopline::cloud_localisation {
namespace {

using lidar_mapping::SweepPoint;

constexpr double ground_range_m = 25;
constexpr std::size_t least_ground = 30;
constexpr double ground_sigma_m = 0.1;  ///< of a lowest point about the ground; farther off it counts less
constexpr int ground_rounds = 12;
constexpr double field_sigma_m = 0.7;

double median(std::vector<double>& values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

}  // namespace

SweepFromAbove seen_from_above(const std::vector<SweepPoint>& points, const Twist3& velocity,
                               double range_m) {
    SweepFromAbove seen;
    const lidar_mapping::SweepMotion motion(velocity);
    UprightColumns columns;
    std::vector<Eigen::Vector3d> places_m;
    places_m.reserve(points.size());
    for (const SweepPoint& point : points) {
        places_m.push_back(lidar_mapping::undistorted(point, motion));
        if (places_m.back().head<2>().norm() < range_m) columns.add(places_m.back());
    }
    // In the order of the sweep: a column is told by the first point that it has.
    UprightColumns told;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const Eigen::Vector3d& p_m = places_m[i];
        if (!(p_m.head<2>().norm() < range_m)) continue;
        const auto* column = columns.find(p_m.x(), p_m.y());
        if (column->is_upright()) seen.standing.push_back(points[i]);
        if (told.find(p_m.x(), p_m.y()) != nullptr) continue;
        told.add(p_m);
        const Eigen::Vector2f middle_m =
            (Eigen::Vector2f(static_cast<float>(UprightColumns::index_of(p_m.x())),
                             static_cast<float>(UprightColumns::index_of(p_m.y()))) +
             Eigen::Vector2f::Constant(0.5F)) *
            static_cast<float>(UprightColumns::cell_m);
        if (column->is_upright()) seen.upright_base_m.push_back(middle_m);
        if (p_m.head<2>().norm() < ground_range_m)
            seen.lowest_base_m.emplace_back(middle_m.x(), middle_m.y(), column->low_m);
    }
    return seen;
}

std::optional<Pose3> on_ground(const UprightColumns& map, const std::vector<Eigen::Vector3f>& lowest_base_m,
                               const Pose2& T_map_base) {
    std::vector<Eigen::Vector3d> rows;  // of 1, -x, y
    std::vector<double> rises_m;
    for (const Eigen::Vector3f& p : lowest_base_m) {
        const Eigen::Vector2d at_m = T_map_base * Eigen::Vector2d(p.x(), p.y());
        const auto* column = map.find(at_m.x(), at_m.y());
        if (column == nullptr) continue;
        rows.emplace_back(1, -p.x(), p.y());
        rises_m.push_back(column->low_m - p.z());
    }
    if (rows.size() < least_ground) return std::nullopt;
    std::vector<double> sorted = rises_m;
    Eigen::Vector3d z_pitch_roll(median(sorted), 0, 0);
    for (int round = 0; round < ground_rounds; ++round) {
        // The vehicle stands on wheels: little tilt, where the ground does not tell it.
        Eigen::Matrix3d A = Eigen::Vector3d(1e-6, 10, 10).asDiagonal();
        Eigen::Vector3d b = Eigen::Vector3d::Zero();
        for (std::size_t i = 0; i < rows.size(); ++i) {
            const double e = (rises_m[i] - rows[i].dot(z_pitch_roll)) / ground_sigma_m;
            const double w = 1 / (1 + e * e);
            A += w * rows[i] * rows[i].transpose();
            b += w * rises_m[i] * rows[i];
        }
        z_pitch_roll = A.ldlt().solve(b);
    }
    const Eigen::Quaterniond tilt = Eigen::AngleAxisd(z_pitch_roll.y(), Eigen::Vector3d::UnitY()) *
                                    Eigen::AngleAxisd(z_pitch_roll.z(), Eigen::Vector3d::UnitX());
    Pose3 placed(T_map_base);
    placed.translation_m.z() = z_pitch_roll.x();
    placed.rotation = placed.rotation * tilt;
    return placed;
}

UprightField::UprightField(const UprightColumns& map, const Eigen::Vector2d& middle_m, double radius_m) {
    const int cells = static_cast<int>(radius_m / UprightColumns::cell_m) + 1;
    const int x0 = UprightColumns::index_of(middle_m.x()) - cells,
              y0 = UprightColumns::index_of(middle_m.y()) - cells;
    side_ = 2 * cells + 1;
    x0_m_ = static_cast<float>(x0 * UprightColumns::cell_m);
    y0_m_ = static_cast<float>(y0 * UprightColumns::cell_m);
    values_.assign(static_cast<std::size_t>(side_) * static_cast<std::size_t>(side_), 0);
    for (int y = 0; y < side_; ++y)
        for (int x = 0; x < side_; ++x) {
            const auto* column = map.find(x0 + x, y0 + y);
            if (column == nullptr) continue;
            ++columns_;
            if (!column->is_upright()) continue;
            ++upright_;
            stamp(x, y);
        }
}

void UprightField::stamp(int x, int y) {
    constexpr int reach = 4;
    for (int dy = -reach; dy <= reach; ++dy)
        for (int dx = -reach; dx <= reach; ++dx) {
            if (x + dx < 0 || y + dy < 0 || x + dx >= side_ || y + dy >= side_) continue;
            const double d_m = std::hypot(dx, dy) * UprightColumns::cell_m / field_sigma_m;
            const auto value = static_cast<std::uint8_t>(std::lround(255 * std::exp(-d_m * d_m / 2)));
            auto& cell = values_[static_cast<std::size_t>(y + dy) * static_cast<std::size_t>(side_) +
                                 static_cast<std::size_t>(x + dx)];
            cell = std::max(cell, value);
        }
}

}  // namespace loopline::cloud_localisation
