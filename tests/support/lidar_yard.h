/// A yard and a corridor of rectangles, the map of their surfaces, and sweeps of a lidar that moves in them.
#pragma once

#include <random>
#include <vector>

#include "inertial/rotation_vector.h"
#include "lidar_mapping/registration.h"

namespace loopline::lidar_yard {

using namespace lidar_mapping;

inline constexpr double deg = M_PI / 180;

/// A rectangle in space: corner, and its two edges.
struct Panel {
    Eigen::Vector3d corner_m, edge_a_m, edge_b_m;
};

/// A yard 30 m x 20 m with walls, a floor and a slanting roof on one side.
inline std::vector<Panel> yard() {
    return {{{-15, -10, 0}, {30, 0, 0}, {0, 20, 0}}, {{-15, -10, 0}, {30, 0, 0}, {0, 0, 6}},
            {{-15, 10, 0}, {30, 0, 0}, {0, 0, 6}},   {{-15, -10, 0}, {0, 20, 0}, {0, 0, 6}},
            {{15, -10, 0}, {0, 20, 0}, {0, 0, 6}},   {{-15, 2, 6}, {20, 0, 0}, {0, 8, 3}},
            {{4, -3, 0}, {3, 1, 0}, {0, 0, 2.5}},    {{-8, 4, 0}, {1, -2, 0}, {0, 0, 2}}};
}

/// Floor and two walls, the same all along x.
inline std::vector<Panel> corridor(double half_m) {
    return {{{-half_m, -2, 0}, {2 * half_m, 0, 0}, {0, 4, 0}},
            {{-half_m, -2, 0}, {2 * half_m, 0, 0}, {0, 0, 3}},
            {{-half_m, 2, 0}, {2 * half_m, 0, 0}, {0, 0, 3}}};
}

/// Not on the border of two cubes.
inline const Eigen::Vector3d beside_m(0.13, 0.17, 0.11);

inline Eigen::Vector3d place_on(const Panel& panel, std::mt19937_64& random) {
    std::uniform_real_distribution<double> unit(0, 1);
    const double a = unit(random), b = unit(random);
    return beside_m + panel.corner_m + a * panel.edge_a_m + b * panel.edge_b_m;
}

inline const Panel& any_of(const std::vector<Panel>& panels, std::mt19937_64& random) {
    std::vector<double> areas_m2;
    for (const Panel& p : panels) areas_m2.push_back(p.edge_a_m.cross(p.edge_b_m).norm());
    std::discrete_distribution<std::size_t> by_area(areas_m2.begin(), areas_m2.end());
    return panels[by_area(random)];
}

/// A return as it is in a map that knows nothing of noise, seen straight from above.
inline MapReturn from_above(const Eigen::Vector3d& p_map_m) {
    return {p_map_m, {0, 0, -1}};
}
inline const Eigen::Matrix3f no_noise = Eigen::Matrix3f::Zero();

inline SurfaceMap map_of(const std::vector<Panel>& panels, double sigma_m, std::mt19937_64& random) {
    SurfaceMap map{SurfaceMapSettings{}};
    std::normal_distribution<double> normal;
    for (int k = 0; k < 100000; ++k) {
        const Panel& panel = any_of(panels, random);
        const Eigen::Vector3d n = panel.edge_a_m.cross(panel.edge_b_m).normalized();
        const Eigen::Vector3d p = place_on(panel, random) + sigma_m * normal(random) * n;
        for (std::size_t size = 0; size < map.sizes(); ++size) map.add(size, {p, no_noise});
    }
    return map;
}

/// Points of a sweep of 0.1 s, each from where the vehicle is at its time.
inline std::vector<SweepPoint> sweep_of(const std::vector<Panel>& panels, const MotionState& truth,
                                        int points, std::mt19937_64& random) {
    std::vector<SweepPoint> sweep;
    for (int k = 0; k < points; ++k) {
        const double time_s = -0.05 + 0.1 * k / points;
        const Eigen::Vector3d p =
            pose_near(truth, time_s).inverse() * place_on(any_of(panels, random), random);
        sweep.push_back({p.cast<float>(), static_cast<float>(time_s), p.normalized().cast<float>()});
    }
    return sweep;
}

inline MotionState state_near(const MotionState& truth, const Vector12d& off, double sigma_m,
                              double sigma_rad) {
    MotionState state = moved_by(truth, off);
    Vector12d sigma;
    sigma << Eigen::Vector3d::Constant(sigma_m), Eigen::Vector3d::Constant(sigma_rad),
        Eigen::Vector3d::Constant(10 * sigma_m), Eigen::Vector3d::Constant(10 * sigma_rad);
    state.covariance = sigma.cwiseAbs2().asDiagonal();
    return state;
}

inline MotionState driving() {
    MotionState truth;
    truth.T_map_base = {{1, -2, 1.5}, inertial::exp_so3({0.02, -0.03, 0.7})};
    truth.velocity = {{8, 0.2, -0.1}, {0.05, -0.1, 0.6}};
    return truth;
}

}  // namespace loopline::lidar_yard
