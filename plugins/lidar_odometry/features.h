/// Edge points and planar points of a sweep, chosen ring by ring. Yu, Zheng, Ou, Wang 2022, eq. (1) and (7);
/// Zhang and Singh 2014, "LOAM: Lidar odometry and mapping in real-time", section V.A.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "lidar/spinning_scan.h"

namespace loopline::lidar_odometry {

/// A place on the surroundings, in the vehicle's frame at the moment of its beam.
struct Feature {
    Eigen::Vector3f p_base_m;
    /// Of a planar point: unit vector along its ring, which lies in the surface; zero of an edge point.
    Eigen::Vector3f along_base = Eigen::Vector3f::Zero();
    Eigen::Vector3f beam_base = Eigen::Vector3f::Zero();  ///< of a planar point: unit vector of its beam
    float time_s = 0;                                     ///< after the middle of the sweep
    /// Of an edge point across its edge; of a planar point along its beam, and what is added across its
    /// surface.
    float variance_m2 = 0, roughness_m2 = 0;
    std::uint16_t ring = 0;  ///< from the highest beam, 0, to the lowest
    std::uint8_t matched =
        0;  ///< 1: one of those that are matched with the sweep before; all are matched with
};

/// Of a planar point along a normal: noise of ranges counts as far as it leads off the surface.
inline double variance_along(const Feature& planar, const Eigen::Vector3d& normal) {
    const double sine = normal.dot(planar.beam_base.cast<double>());
    return sine * sine * static_cast<double>(planar.variance_m2) + static_cast<double>(planar.roughness_m2);
}

/// Ring after ring, from the highest.
struct SweepFeatures {
    std::vector<Feature> edges, planar;
};

struct FeatureSettings {
    double min_range_m = 1.5, max_range_m = 100;  ///< eq. (7): nothing outside counts
    int sectors = 6;                              ///< equal parts of a ring, so that features lie all around
    int edges_per_sector = 4, planes_per_sector = 6;  ///< that are matched with the sweep before
    int edges_kept_per_sector = 20;                   ///< that the next sweep is matched with
    double min_edge_curvature = 0.005;                ///< of eq. (1)
    double planar_spacing_m = 0.3;  ///< along a ring; a planar point is the mean of what it stands for
    double sigma_range_m = 0.02;
    double sigma_surface_m = 0.005;  ///< roughness and errors of beams, which no mean takes away
    double sigma_edge_m = 0.05;      ///< beams are wide, and edges seldom sharp
};

/// Keeps its memory from sweep to sweep.
class FeatureFinder {
 public:
    void find(const lidar::SpinningScan& scan, const FeatureSettings& settings, SweepFeatures& features);

    /// Points on each side of a point that are its neighbourhood S in eq. (1).
    static constexpr int half_window = 5;

 private:
    /// Returns of one ring within the range gate, in the order of their times.
    struct Ring {
        std::vector<float> x_m, y_m, z_m, time_s, range_m;
        std::vector<float> curvature;     ///< c of eq. (1)
        std::vector<float> width_m;       ///< from the first of a neighbourhood to its last
        std::vector<std::uint8_t> open;   ///< 1: a surface ends between this return and the next
        std::vector<std::uint8_t> unfit;  ///< 1: no edge point, 2: no planar point, 3: neither
        std::size_t size() const { return x_m.size(); }
        Eigen::Vector3f point(std::size_t i) const { return {x_m[i], y_m[i], z_m[i]}; }
        void clear();
    };
    /// A run of neighbouring planar returns.
    struct Group {
        std::size_t begin = 0, end = 0;
        float curvature = 0;  ///< mean
    };

    void take_ring(const lidar::SpinningScan& scan, std::size_t ring, const FeatureSettings& settings);
    void find_curvature();
    void find_unfit();
    void mark(std::size_t begin, std::size_t end, std::uint8_t what);
    void choose_edges(std::uint16_t ring, const FeatureSettings& settings, std::vector<Feature>& edges);
    void choose_planar(std::uint16_t ring, const FeatureSettings& settings, std::vector<Feature>& planar);
    void find_groups(std::size_t begin, std::size_t end, const FeatureSettings& settings);
    Feature edge_at(std::size_t i, std::uint16_t ring, const FeatureSettings& settings) const;
    Feature feature_at(const Eigen::Vector3f& p_lidar_m, float time_s, std::uint16_t ring) const;
    /// None if the returns do not lie on a straight line, but for noise.
    std::optional<Feature> mean_of(const Group& group, std::uint16_t ring,
                                   const FeatureSettings& settings) const;

    Ring ring_;
    std::vector<std::uint8_t> hidden_;  ///< 1: what is nearer than the range gate stands before the next
    std::vector<std::size_t> candidates_;
    std::vector<Group> groups_;
    float beam_step_rad_ = 0;  ///< between two returns of a ring
    Eigen::Matrix3f R_base_lidar_;
    Eigen::Vector3f t_base_lidar_m_;
    float middle_s_ = 0;
};

}  // namespace loopline::lidar_odometry
