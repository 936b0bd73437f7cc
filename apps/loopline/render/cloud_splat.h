/// A cloud of millions of points as an opaque surface, by a depth buffer, in a parallel projection: some ten
/// nanoseconds a point, without OpenGL.
#pragma once

#include <mrpt/maps/CPointsMap.h>

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "render/content_bounds.h"

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

/// Draws the points onto `bgr`, each 2 x 2 pixels, the nearest in front, coloured by height; what stands
/// behind an edge is darkened, so that surfaces come apart (eye-dome lighting, Boucheny 2009). Returns how
/// near to the eye the surface is at each pixel, in the view's z; minus infinity where there is none.
cv::Mat1f splat_cloud(cv::Mat& bgr, const mrpt::maps::CPointsMap& cloud, const ParallelView& view,
                      const HeightColours& colours);

/// Of all but the farthest 0.1 % of the points in each direction, in the axes of `axes` (rows; identity: the
/// map's).
Bounds bounds_of_cloud(const mrpt::maps::CPointsMap& cloud, const Eigen::Matrix3d& axes);

/// Colours for the heights of a cloud, cut below its ceiling if it has one: a level near its top that holds
/// many times more points than the heights under it.
HeightColours height_colours(const mrpt::maps::CPointsMap& cloud);

}  // namespace loopline
