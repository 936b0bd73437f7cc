/// A cloud of millions of points as an opaque surface, by a depth buffer, in a parallel projection: some ten
/// nanoseconds a point, without OpenGL.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "render/content_bounds.h"
#include "render/point_source.h"

namespace loopline {

/// A parallel projection: x right and y down in pixels, z towards the eye in metres.
struct ParallelView {
    Eigen::Matrix3f linear = Eigen::Matrix3f::Identity();
    Eigen::Vector3f offset = Eigen::Vector3f::Zero();
    Eigen::Vector3f operator()(const Eigen::Vector3f& p_map) const { return linear * p_map + offset; }
};

struct HeightColours {
    double lowest_m = 0, highest_m = 1;
    /// Points above it are not drawn: a ceiling would hide the rooms under it.
    double cut_m = INFINITY;
};

/// Draws the points onto `bgr`, each `side_px` pixels wide and high, the nearest in front, coloured by
/// height; what stands behind an edge is darkened, so that surfaces come apart (eye-dome lighting, Boucheny
/// 2009). Returns how near to the eye the surface is at each pixel, in the view's z; minus infinity where
/// there is none.
cv::Mat1f splat_cloud(cv::Mat& bgr, const PointSource& cloud, const ParallelView& view,
                      const HeightColours& colours, int side_px = 2);

/// Of all but the farthest points in each direction, a share `left_out` at each end, in the axes of `axes`
/// (rows; identity: the map's).
Bounds bounds_of_cloud(const PointSource& cloud, const Eigen::Matrix3d& axes, double left_out = 0.001);

/// Colours for the heights of a cloud, cut below its ceiling if it has one: a level near its top that holds
/// many times more points than the heights under it.
HeightColours height_colours(const PointSource& cloud);

}  // namespace loopline
