/// The returns of one scan as points, with running sums of their moments: the least-squares line of any run
/// of neighbours then costs the same, however long it is.
#pragma once

#include <cmath>
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

/// Sums over a set of points: count, coordinates, their products, and cosine and sine of twice the bearing.
struct Moments {
    double n = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0, cos2 = 0, sin2 = 0;

    Moments operator-(const Moments& o) const {
        return {n - o.n, x - o.x, y - o.y, xx - o.xx, xy - o.xy, yy - o.yy, cos2 - o.cos2, sin2 - o.sin2};
    }
    Moments operator+(const Moments& o) const {
        return {n + o.n, x + o.x, y + o.y, xx + o.xx, xy + o.xy, yy + o.yy, cos2 + o.cos2, sin2 + o.sin2};
    }
};

/// One return. Coordinates are in the scan frame: at the sensor, x along the middle of the sweep, so that
/// what is found does not depend on how the sensor is turned.
struct ScanPoint {
    double x_m = 0, y_m = 0;
    std::size_t beam = 0;

    double squared_range_m2() const { return x_m * x_m + y_m * y_m; }
};

class ScanPoints {
 public:
    /// Replaces the points by the returns of `scan`. Sines and cosines are kept as long as the beam geometry
    /// stays.
    void load(const PlanarScan& scan);

    std::size_t size() const { return size_; }
    ScanPoint operator[](std::size_t i) const { return {x_m_[i], y_m_[i], beam_[i]}; }
    double squared_distance_m2(std::size_t i, std::size_t j) const {
        const double dx = x_m_[j] - x_m_[i], dy = y_m_[j] - y_m_[i];
        return dx * dx + dy * dy;
    }
    Moments moments(const Interval& run) const {
        Moments sums = sums_[run.end] - sums_[run.begin];
        sums.n = static_cast<double>(run.size());
        return sums;
    }
    /// Moments of the points before i, without their count.
    const Moments& sums_before(std::size_t i) const { return sums_[i]; }

    /// inverse()[n] = 1 / n for n from 1 to size().
    const double* inverse() const { return inverse_.data(); }

    /// All points' coordinates and ranges; a vector that begins at the last of them may be read.
    const double* x_m() const { return x_m_.data(); }
    const double* y_m() const { return y_m_.data(); }
    const double* range_m() const { return range_m_.data(); }

    double angle_step_rad() const { return angle_step_rad_; }
    double sin_angle_step() const { return sin_angle_step_; }
    /// Direction of the scan frame's x axis in the sensor frame.
    double middle_angle_rad() const { return middle_angle_rad_; }
    double cos_middle() const { return cos_middle_; }
    double sin_middle() const { return sin_middle_; }
    bool full_circle() const { return full_circle_; }

 private:
    void prepare(std::size_t beams, double angle_step_rad);

    std::size_t size_ = 0;
    std::vector<double> x_m_, y_m_, range_m_;
    std::vector<double> inverse_;  ///< 1 / index
    std::vector<Moments> sums_;    ///< of the points before index i
    std::vector<std::uint32_t> beam_;

    struct Direction {
        double cos, sin, cos2, sin2;  ///< of a beam's bearing and of twice that
    };
    std::vector<Direction> directions_;
    double angle_step_rad_ = 0, sin_angle_step_ = 0, middle_angle_rad_ = 0;
    double cos_middle_ = 1, sin_middle_ = 0;
    bool full_circle_ = false;
};

}  // namespace loopline::lines
