/// The returns of one scan as points, with running sums of their moments: the least-squares line of any run
/// of neighbours then costs the same, however long it is.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "api/planar_scan.h"

namespace loopline::lines {

/// Neighbouring points [begin, end) of a ScanPoints.
struct Interval {
    std::size_t begin = 0;
    std::size_t end = 0;
    std::size_t size() const { return end - begin; }
};

/// Sums over a set of points: count, coordinates, their products, and 1/range^2.
struct Moments {
    double n = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0, inverse_rr = 0;

    Moments operator-(const Moments& o) const {
        return {n - o.n, x - o.x, y - o.y, xx - o.xx, xy - o.xy, yy - o.yy, inverse_rr - o.inverse_rr};
    }
    Moments operator+(const Moments& o) const {
        return {n + o.n, x + o.x, y + o.y, xx + o.xx, xy + o.xy, yy + o.yy, inverse_rr + o.inverse_rr};
    }
};

/// One return. Coordinates are in the scan frame: at the sensor, x along the middle of the sweep, so that
/// what is found does not depend on how the sensor is turned.
struct ScanPoint {
    double x_m = 0, y_m = 0;
    double cos_bearing = 1, sin_bearing = 0;  ///< the beam's direction
    double range_m = 0;
    std::size_t beam = 0;
};

class ScanPoints {
 public:
    /// Replaces the points by the returns of `scan`. Sines and cosines are kept as long as the beam geometry
    /// stays.
    void load(const PlanarScan& scan);

    std::size_t size() const { return points_.size(); }
    const ScanPoint& operator[](std::size_t i) const { return points_[i]; }
    Moments moments(const Interval& run) const { return sums_[run.end] - sums_[run.begin]; }
    double squared_distance_m2(std::size_t i, std::size_t j) const {
        const double dx = points_[j].x_m - points_[i].x_m, dy = points_[j].y_m - points_[i].y_m;
        return dx * dx + dy * dy;
    }

    double angle_step_rad() const { return angle_step_rad_; }
    double sin_angle_step() const { return sin_angle_step_; }
    /// Direction of the scan frame's x axis in the sensor frame.
    double middle_angle_rad() const { return middle_angle_rad_; }
    double cos_middle() const { return cos_middle_; }
    double sin_middle() const { return sin_middle_; }
    bool full_circle() const { return full_circle_; }

 private:
    void tabulate_directions(std::size_t beams, double angle_step_rad);

    std::vector<ScanPoint> points_;
    std::vector<Moments> sums_;  ///< of the points before index i
    std::vector<double> cos_, sin_;
    double angle_step_rad_ = 0, sin_angle_step_ = 0, middle_angle_rad_ = 0;
    double cos_middle_ = 1, sin_middle_ = 0;
    bool full_circle_ = false;
};

}  // namespace loopline::lines
