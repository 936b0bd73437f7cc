/// A scan as the map keeps it: its returns in the vehicle's frame, each with the direction of the surface
/// around it.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "api/planar_scan.h"

namespace loopline::grid_map {

/// A return, and the surface that it lies on.
struct SurfacePoint {
    Eigen::Vector2f p_base_m;
    /// Unit vector towards the sensor; zero where the returns beside this one don't make a surface.
    Eigen::Vector2f normal_base;
    bool has_normal() const { return normal_base.squaredNorm() > 0.5F; }
};

struct Frame {
    Eigen::Vector2f p_base_sensor_m = Eigen::Vector2f::Zero();
    std::vector<SurfacePoint> points;  ///< in the order of their angle
};

/// Of its returns from the sensor; 1 if there are none.
double mean_range_m(const Frame& frame);

struct FrameSettings {
    double min_range_m = 0.1;       ///< nearer returns are of the vehicle itself
    double max_range_m = 30;        ///< farther ones are left out
    double surface_half_m = 0.1;    ///< how far to both sides of a return its surface is fitted
    double sigma_surface_m = 0.03;  ///< standard deviation about the fitted line, up to which it is a surface
    double spacing_m = 0.04;  ///< of returns along a surface that are kept; what is nearer tells nothing new
};

/// How the vehicle moves from the first beam of a scan to the last, at constant twist, along its own axes at
/// the first.
struct SweepMotion {
    double forward_m = 0, left_m = 0, turn_rad = 0;
};

/// The returns of a scan with their surfaces, as seen from where the vehicle is at the first beam; into
/// `frame`, whose memory is used again.
void make_frame(const PlanarScan& scan, const SweepMotion& motion, const FrameSettings& settings,
                Frame& frame);

}  // namespace loopline::grid_map
