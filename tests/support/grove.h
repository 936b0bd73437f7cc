/// A drive among trees: what its wheels count and what it sees, all of it known.
#pragma once

#include <cmath>
#include <random>
#include <vector>

#include "landmark_odometry/landmark_odometry.h"

namespace loopline::landmark_odometry::test {

struct GroveSettings {
    double sigma_range_m = 0.1, sigma_bearing_rad = 0.5 * M_PI / 180, reach_m = 30;
    bool errs = true;                            ///< by these; else they are only what is claimed
    double missed = 0.1, false_sightings = 0.3;  ///< part of trees, and how many a scan
    MotionNoise motion{0.02, 0.02, 0.3 * M_PI / 180, 0};
    double scale = 1, turn_scale = 1;  ///< what wheels tell of the truth
    double trees_per_m2 = 0.008, half_side_m = 90;
};

/// A figure of eight about a place where no tree stands in the way.
class Grove {
 public:
    static constexpr double step_m = 0.5;

    Grove(const GroveSettings& settings, std::uint64_t seed) : s_(settings), random_(seed) {
        std::uniform_real_distribution<double> side(-s_.half_side_m, s_.half_side_m);
        const auto count = static_cast<int>(s_.trees_per_m2 * 4 * s_.half_side_m * s_.half_side_m);
        for (int k = 0; k < count; ++k) trees_m_.emplace_back(side(random_), side(random_));
    }

    const Pose2& T_map_base() const { return T_map_base_; }
    double way_m() const { return way_m_; }

    /// Drives on and returns what the wheels tell of it.
    Twist2 drive() {
        const double curvature_per_m = std::fmod(way_m_, 400) < 200 ? 2 * M_PI / 200 : -2 * M_PI / 200;
        const Twist2 truth{step_m, 0, curvature_per_m * step_m};
        T_map_base_ = T_map_base_ * exp_se2(truth);
        way_m_ += step_m;
        const double root = std::sqrt(step_m);
        return {truth.forward_m * s_.scale + s_.motion.along_m * root * normal_(random_),
                s_.motion.across_m * root * normal_(random_),
                truth.turn_rad * s_.turn_scale + s_.motion.heading_rad * root * normal_(random_)};
    }

    std::vector<Sighting> look() {
        std::vector<Sighting> sightings;
        std::uniform_real_distribution<double> part(0, 1);
        for (const Eigen::Vector2d& tree_m : trees_m_) {
            const Eigen::Vector2d p_m = T_map_base_.inverse() * tree_m;
            if (p_m.x() < 0 || p_m.norm() > s_.reach_m || p_m.norm() < 1 || part(random_) < s_.missed)
                continue;
            sightings.push_back(sighting(p_m.norm() + error() * s_.sigma_range_m,
                                         std::atan2(p_m.y(), p_m.x()) + error() * s_.sigma_bearing_rad));
        }
        for (double left = s_.false_sightings; left > 0; left -= 1)
            if (part(random_) < left)
                sightings.push_back(
                    sighting(1 + (s_.reach_m - 1) * part(random_), M_PI * (part(random_) - 0.5)));
        return sightings;
    }

 private:
    double error() { return s_.errs ? normal_(random_) : 0; }
    Sighting sighting(double range_m, double bearing_rad) const {
        const double c = std::cos(bearing_rad), s = std::sin(bearing_rad);
        Eigen::Matrix2d J;
        J << c * s_.sigma_range_m, -s * range_m * s_.sigma_bearing_rad, s * s_.sigma_range_m,
            c * range_m * s_.sigma_bearing_rad;
        return {{range_m * c, range_m * s}, J * J.transpose()};
    }

    GroveSettings s_;
    std::mt19937_64 random_;
    std::normal_distribution<double> normal_{0, 1};
    std::vector<Eigen::Vector2d> trees_m_;
    Pose2 T_map_base_;
    double way_m_ = 0;
};

}  // namespace loopline::landmark_odometry::test
