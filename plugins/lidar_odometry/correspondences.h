/// Edge point to line, planar point to plane: which points of the sweep before a point of this one belongs
/// to. Yu et al. 2022, section 1.2 and fig. 3; Zhang and Singh 2014, section V.B.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "api/pose3_motion.h"
#include "lidar_odometry/features.h"
#include "lidar_odometry/kd_tree.h"

namespace loopline::lidar_odometry {

/// The features of the sweep before, all seen from the vehicle in the middle of it.
struct ReferenceSweep {
    std::vector<Feature> edges, planar;
    KdTree edge_tree, planar_tree;
    std::vector<KdTree> planar_of_ring;

    /// Takes out the motion at `velocity` (a second) during the sweep.
    void set(const SweepFeatures& features, const Twist3& velocity);

 private:
    std::vector<Eigen::Vector3f> points_m_;
};

struct CorrespondenceSettings {
    double max_distance_m = 3;   ///< to each of the points that make a line or a plane
    int max_ring_gap = 2;        ///< between the two points of a line: not every ring has its edge point
    double alone_m = 1;          ///< a plane whose rings are farther apart needs a fourth point that agrees
    double max_tilt_rad = 0.26;  ///< between a plane and the rings that lie in it
    double sigma_bend_per_m = 0.002;  ///< curvature of surfaces that count as planes
};

/// A line by the nearest edge point and the nearest one to it on a neighbouring ring.
struct LineOfEdges {
    std::uint32_t nearest = 0, other = 0;
    Eigen::Vector3d direction, point_m;
    double variance_m2 = 0;  ///< of the line across itself, at the place nearest to the edge point
};

/// A plane by the nearest planar point, the next nearest of its ring, and the nearest of a neighbouring ring.
struct PlaneOfPoints {
    std::uint32_t nearest = 0, same_ring = 0, other_ring = 0;
    Eigen::Vector3d normal, point_m;
    double variance_m2 = 0;  ///< of the plane along its normal, at the foot of the planar point
    /// An error of a vertex by its standard deviation along the normal turns the normal by this.
    std::array<Eigen::Vector3d, 3> turned_by;
};

/// `p_before_m`: an edge point of this sweep, seen from before by what is known so far.
std::optional<LineOfEdges> find_line(const ReferenceSweep& before, const Eigen::Vector3d& p_before_m,
                                     const CorrespondenceSettings& settings);
/// `along_before`: the direction of the planar point's own ring.
std::optional<PlaneOfPoints> find_plane(const ReferenceSweep& before, const Eigen::Vector3d& p_before_m,
                                        const Eigen::Vector3d& along_before,
                                        const CorrespondenceSettings& settings);

}  // namespace loopline::lidar_odometry
