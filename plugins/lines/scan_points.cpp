#include "lines/scan_points.h"

#include <limits>

#include "lines/vectorised.h"

namespace loopline::lines {

void ScanPoints::prepare(std::size_t beams, double angle_step_rad) {
    if (sums_.size() == beams + 1 && angle_step_rad_ == angle_step_rad) return;
    for (auto* values : {&x_m_, &y_m_, &range_m_}) values->assign(beams + vector_points, 0);
    sums_.resize(beams + 1);
    inverse_.resize(beams + 1);
    for (std::size_t n = 1; n <= beams; ++n) inverse_[n] = 1 / static_cast<double>(n);
    beam_.resize(beams);
    directions_.resize(beams);
    const double middle = 0.5 * (static_cast<double>(beams) - 1);
    for (std::size_t i = 0; i < beams; ++i) {
        const double bearing_rad = (static_cast<double>(i) - middle) * angle_step_rad;
        directions_[i] = {std::cos(bearing_rad), std::sin(bearing_rad), std::cos(2 * bearing_rad),
                          std::sin(2 * bearing_rad)};
    }
    angle_step_rad_ = angle_step_rad;
    sin_angle_step_ = std::sin(angle_step_rad);
}

LOOPLINE_VECTORISED void ScanPoints::load(const PlanarScan& scan) {
    const std::size_t beams = scan.size();
    prepare(beams, scan.angle_step_rad);
    const double sweep_rad = beams > 0 ? static_cast<double>(beams - 1) * scan.angle_step_rad : 0;
    middle_angle_rad_ = scan.first_angle_rad + 0.5 * sweep_rad;
    full_circle_ = sweep_rad + 1.5 * scan.angle_step_rad > 2 * M_PI;
    cos_middle_ = std::cos(middle_angle_rad_);
    sin_middle_ = std::sin(middle_angle_rad_);

    const float* const ranges_m = scan.ranges_m.data();
    const Direction* const directions = directions_.data();
    double *const x_m = x_m_.data(), *const y_m = y_m_.data(), *const range_m = range_m_.data();
    std::uint32_t* const beam = beam_.data();
    Moments* const sums = sums_.data();
    // One by one: the compiler would gather and scatter the sums of a Moments.
    double sum_x = 0, sum_y = 0, sum_xx = 0, sum_xy = 0, sum_yy = 0, sum_cos2 = 0, sum_sin2 = 0;
    sums[0] = {};
    std::size_t count = 0;
    for (std::size_t i = 0; i < beams; ++i) {
        const float r = ranges_m[i];
        if (!(r > 0 && r <= std::numeric_limits<float>::max())) continue;
        const double range = r, x = range * directions[i].cos, y = range * directions[i].sin;
        range_m[count] = range;
        x_m[count] = x;
        y_m[count] = y;
        beam[count] = static_cast<std::uint32_t>(i);
        Moments& sum = sums[++count];
        sum.x = sum_x += x;
        sum.y = sum_y += y;
        sum.xx = sum_xx += x * x;
        sum.xy = sum_xy += x * y;
        sum.yy = sum_yy += y * y;
        sum.cos2 = sum_cos2 += directions[i].cos2;
        sum.sin2 = sum_sin2 += directions[i].sin2;
    }
    size_ = count;
}

}  // namespace loopline::lines
