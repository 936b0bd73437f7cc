#include "lidar_odometry/correspondences.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "lidar_odometry/triangle.h"

namespace loopline::lidar_odometry {
namespace {

/// Lines are used so much of their length beyond the two points.
constexpr double beyond = 1;
constexpr double least_length_m = 0.05;

void undistort(const std::vector<Feature>& features, const Twist3& velocity, std::vector<Feature>& seen,
               std::vector<Eigen::Vector3f>& points_m) {
    seen = features;
    points_m.clear();
    for (Feature& feature : seen) {
        const Pose3 T_middle_then = exp_se3(velocity * static_cast<double>(feature.time_s));
        feature.p_base_m = (T_middle_then * Eigen::Vector3d(feature.p_base_m.cast<double>())).cast<float>();
        feature.beam_base = (T_middle_then.rotation * feature.beam_base.cast<double>()).cast<float>();
        feature.along_base = (T_middle_then.rotation * feature.along_base.cast<double>()).cast<float>();
        points_m.push_back(feature.p_base_m);
    }
}

bool on_neighbouring_rings(std::uint16_t ring, std::uint16_t other, int gap) {
    return ring != other && std::abs(int{ring} - int{other}) <= gap;
}

/// The planar point of one ring that is nearest to a place; `not_this` does not count.
std::uint32_t nearest_of_ring(const ReferenceSweep& before, int ring, const Eigen::Vector3f& p_m, float max_m,
                              std::uint32_t not_this = KdTree::none) {
    if (ring < 0 || static_cast<std::size_t>(ring) >= before.planar_of_ring.size()) return KdTree::none;
    return before.planar_of_ring[static_cast<std::size_t>(ring)].nearest(
        p_m, max_m, [&](std::uint32_t i) { return i != not_this; });
}

/// The nearer one of the two neighbouring rings'.
std::uint32_t nearest_beside_ring(const ReferenceSweep& before, int ring, const Eigen::Vector3f& p_m,
                                  float max_m) {
    const std::uint32_t above = nearest_of_ring(before, ring - 1, p_m, max_m),
                        below = nearest_of_ring(before, ring + 1, p_m, max_m);
    if (above == KdTree::none || below == KdTree::none) return std::min(above, below);
    const auto distance2 = [&](std::uint32_t i) { return (before.planar[i].p_base_m - p_m).squaredNorm(); };
    return distance2(below) < distance2(above) ? below : above;
}

/// A plane that leads over a step is none: the ring at the other side must agree.
bool holds_beyond(const ReferenceSweep& before, const PlaneOfPoints& plane, const Triangle& triangle,
                  const CorrespondenceSettings& settings) {
    const Feature &corner = before.planar[plane.nearest], &other = before.planar[plane.other_ring];
    const float apart_m = (other.p_base_m - corner.p_base_m).norm();
    const std::uint32_t fourth =
        nearest_of_ring(before, 2 * int{corner.ring} - int{other.ring}, corner.p_base_m,
                        static_cast<float>(settings.max_distance_m) + apart_m);
    if (fourth == KdTree::none) return static_cast<double>(apart_m) < settings.alone_m;
    return triangle.agrees_with(before.planar[fourth], settings.sigma_bend_per_m);
}

}  // namespace

void ReferenceSweep::set(const SweepFeatures& features, const Twist3& velocity) {
    undistort(features.edges, velocity, edges, points_m_);
    edge_tree.build(points_m_);
    undistort(features.planar, velocity, planar, points_m_);
    planar_tree.build(points_m_);
    // Ring after ring, as they were found.
    planar_of_ring.resize(planar.empty() ? 0 : planar.back().ring + std::size_t{1});
    std::size_t begin = 0;
    for (std::size_t ring = 0; ring < planar_of_ring.size(); ++ring) {
        std::size_t end = begin;
        while (end < planar.size() && planar[end].ring == ring) ++end;
        planar_of_ring[ring].build(points_m_, begin, end);
        begin = end;
    }
}

std::optional<LineOfEdges> find_line(const ReferenceSweep& before, const Eigen::Vector3d& p_before_m,
                                     const CorrespondenceSettings& settings) {
    const auto max_m = static_cast<float>(settings.max_distance_m);
    const Eigen::Vector3f p_m = p_before_m.cast<float>();
    LineOfEdges line;
    line.nearest = before.edge_tree.nearest(p_m, max_m);
    if (line.nearest == KdTree::none) return std::nullopt;
    const Feature& a = before.edges[line.nearest];
    line.other = before.edge_tree.nearest(p_m, max_m, [&](std::uint32_t i) {
        return on_neighbouring_rings(a.ring, before.edges[i].ring, settings.max_ring_gap);
    });
    if (line.other == KdTree::none) return std::nullopt;
    const Feature& b = before.edges[line.other];
    line.point_m = a.p_base_m.cast<double>();
    const Eigen::Vector3d way_m = b.p_base_m.cast<double>() - line.point_m;
    const double length_m = way_m.norm();
    if (length_m < least_length_m) return std::nullopt;
    line.direction = way_m / length_m;
    const double part = line.direction.dot(p_before_m - line.point_m) / length_m;
    if (part < -beyond || part > 1 + beyond) return std::nullopt;
    line.variance_m2 = (1 - part) * (1 - part) * static_cast<double>(a.variance_m2) +
                       part * part * static_cast<double>(b.variance_m2);
    return line;
}

std::optional<PlaneOfPoints> find_plane(const ReferenceSweep& before, const Eigen::Vector3d& p_before_m,
                                        const Eigen::Vector3d& along_before,
                                        const CorrespondenceSettings& settings) {
    const auto max_m = static_cast<float>(settings.max_distance_m);
    const Eigen::Vector3f p_m = p_before_m.cast<float>();
    const auto& points = before.planar;
    PlaneOfPoints plane;
    plane.nearest = before.planar_tree.nearest(p_m, max_m);
    if (plane.nearest == KdTree::none) return std::nullopt;
    const int ring = points[plane.nearest].ring;
    plane.same_ring = nearest_of_ring(before, ring, p_m, max_m, plane.nearest);
    if (plane.same_ring == KdTree::none) return std::nullopt;
    plane.other_ring = nearest_beside_ring(before, ring, p_m, max_m);
    if (plane.other_ring == KdTree::none) return std::nullopt;
    const Triangle triangle(points[plane.nearest], points[plane.same_ring], points[plane.other_ring]);
    if (!triangle.is_plane(along_before, std::sin(settings.max_tilt_rad)) || !triangle.covers(p_before_m))
        return std::nullopt;
    if (!holds_beyond(before, plane, triangle, settings)) return std::nullopt;
    plane.normal = triangle.normal();
    plane.point_m = triangle.corner_m();
    plane.variance_m2 = triangle.variance_m2(p_before_m, settings.sigma_bend_per_m);
    plane.turned_by = triangle.turned_by();
    return plane;
}

}  // namespace loopline::lidar_odometry
