#include "lines/scan_points.h"

#include <cmath>

namespace loopline::lines {

void ScanPoints::tabulate_directions(std::size_t beams, double angle_step_rad) {
    if (cos_.size() == beams && angle_step_rad_ == angle_step_rad) return;
    cos_.resize(beams);
    sin_.resize(beams);
    const double middle = 0.5 * (static_cast<double>(beams) - 1);
    for (std::size_t i = 0; i < beams; ++i) {
        const double bearing_rad = (static_cast<double>(i) - middle) * angle_step_rad;
        cos_[i] = std::cos(bearing_rad);
        sin_[i] = std::sin(bearing_rad);
    }
    angle_step_rad_ = angle_step_rad;
    sin_angle_step_ = std::sin(angle_step_rad);
}

void ScanPoints::load(const PlanarScan& scan) {
    const std::size_t beams = scan.size();
    tabulate_directions(beams, scan.angle_step_rad);
    const double sweep_rad = beams > 0 ? static_cast<double>(beams - 1) * scan.angle_step_rad : 0;
    middle_angle_rad_ = scan.first_angle_rad + 0.5 * sweep_rad;
    full_circle_ = sweep_rad + 1.5 * scan.angle_step_rad > 2 * M_PI;

    cos_middle_ = std::cos(middle_angle_rad_);
    sin_middle_ = std::sin(middle_angle_rad_);

    points_.resize(beams);
    sums_.resize(beams + 1);
    Moments sum;
    sums_[0] = sum;
    std::size_t count = 0;
    for (std::size_t i = 0; i < beams; ++i) {
        const double r = scan.ranges_m[i];
        if (!(r > 0) || !std::isfinite(r)) continue;
        const double x = r * cos_[i], y = r * sin_[i];
        points_[count] = {x, y, cos_[i], sin_[i], r, i};
        sum.n += 1;
        sum.x += x;
        sum.y += y;
        sum.xx += x * x;
        sum.xy += x * y;
        sum.yy += y * y;
        sum.inverse_rr += 1 / (r * r);
        sums_[++count] = sum;
    }
    points_.resize(count);
    sums_.resize(count + 1);
}

}  // namespace loopline::lines
