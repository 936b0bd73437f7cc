#include "cloud_map/clear_image.h"

#include <algorithm>
#include <cmath>

#include "cloud_map/azimuth.h"

namespace loopline::cloud_map {
namespace {

// What rounding may do to a place, and azimuth_turns() to its direction.
constexpr float slack_m = 0.002f, slack_turns = 4e-5f;

/// The nearer of two cells; 0 is none.
std::uint16_t nearer(std::uint16_t a, std::uint16_t b) {
    return a == 0 ? b : b == 0 ? a : std::min(a, b);
}

}  // namespace

ClearImage::ClearImage(const RangeView& view)
    : columns_(view.columns_), groups_((view.columns_ + group - 1) / group) {
    const int rows = view.rings() - 1;
    const auto columns = static_cast<std::size_t>(columns_), groups = static_cast<std::size_t>(groups_);
    if (rows < 1) return;
    clear_.resize(static_cast<std::size_t>(rows) * columns);
    farthest_.assign(static_cast<std::size_t>(rows) * groups, 0);
    std::vector<std::uint16_t> of_two(columns);
    for (std::size_t row = 0; row < static_cast<std::size_t>(rows); ++row) {
        const std::uint16_t* upper = &view.ranges_[row * columns];
        for (std::size_t c = 0; c < columns; ++c) of_two[c] = nearer(upper[c], upper[columns + c]);
        std::uint16_t* clear = &clear_[row * columns];
        for (std::size_t c = 0; c < columns; ++c) {
            const std::uint16_t before = of_two[c > 0 ? c - 1 : columns - 1],
                                after = of_two[c + 1 < columns ? c + 1 : 0];
            clear[c] = nearer(of_two[c], nearer(before, after));
            std::uint16_t& most = farthest_[row * groups + c / group];
            most = std::max(most, clear[c]);
        }
    }
}

std::uint64_t ClearImage::Window::sectors() const {
    static_assert(RangeView::sectors == 64);
    const int first = static_cast<int>(std::floor((turns - half_turns) * RangeView::sectors)),
              last = static_cast<int>(std::floor((turns + half_turns) * RangeView::sectors));
    std::uint64_t bits = 0;
    for (int s = first; s <= last; ++s) bits |= std::uint64_t{1} << (s & 63);
    return bits;
}

/// Along the line of sight to the middle, across it, and upwards.
ClearImage::Window ClearImage::window_of(const Eigen::Matrix3f& R_lidar_map, const Eigen::Vector3f& middle_m,
                                         const Eigen::Vector3f& half_m) {
    const Eigen::Vector3f p = R_lidar_map * middle_m;
    const float level_m = std::sqrt(p.x() * p.x() + p.y() * p.y());
    const float cosine = p.x() / std::max(level_m, 1e-3f), sine = p.y() / std::max(level_m, 1e-3f);
    float along_m = slack_m, across_m = slack_m, up_m = slack_m;
    for (int axis = 0; axis < 3; ++axis) {
        const float x = R_lidar_map(0, axis), y = R_lidar_map(1, axis), z = R_lidar_map(2, axis);
        along_m += half_m[axis] * std::abs(cosine * x + sine * y);
        across_m += half_m[axis] * std::abs(cosine * y - sine * x);
        up_m += half_m[axis] * std::abs(z);
    }
    Window window;
    window.turns = azimuth_turns(p.y(), p.x());
    window.level_min_m = std::max(0.0f, level_m - along_m);
    // tan(a) >= a
    window.half_turns = window.level_min_m > across_m
                            ? across_m / window.level_min_m / (2 * static_cast<float>(M_PI)) + slack_turns
                            : 0.5f;
    window.level_max_m = std::sqrt((level_m + along_m) * (level_m + along_m) + across_m * across_m);
    window.z_min_m = p.z() - up_m;
    window.z_max_m = p.z() + up_m;
    return window;
}

bool ClearImage::may_look_through(const RangeView& view, const Eigen::Vector3f& middle_m,
                                  const Eigen::Vector3f& half_m, const ViewSettings& settings) const {
    const Eigen::Vector3f nearest_m = (middle_m.cwiseAbs() - half_m).cwiseMax(0.0f);
    if (clear_.empty() || nearest_m.norm() > static_cast<float>(settings.reach_m) + slack_m) return false;
    // As look() finds a place's sector: by the direction from the origin, and once more from the sector
    // there.
    std::uint64_t asked = 0, sectors = 0;
    const Window first = window_of(view.sectors_[0].R_lidar_map, middle_m, half_m);
    for (std::uint64_t left = first.sectors(); left != 0; left &= left - 1) {
        const auto& s = view.sectors_[static_cast<std::size_t>(__builtin_ctzll(left))];
        const Window window = window_of(s.R_lidar_map, middle_m - s.from_origin_m, half_m);
        const std::uint64_t found = window.sectors(), itself = left & (~left + 1);
        sectors |= found;
        if ((found & itself) == 0) continue;
        asked |= itself;
        if (may_look_through(view, window, settings)) return true;
    }
    for (std::uint64_t left = sectors & ~asked; left != 0; left &= left - 1) {
        const auto& s = view.sectors_[static_cast<std::size_t>(__builtin_ctzll(left))];
        if (may_look_through(view, window_of(s.R_lidar_map, middle_m - s.from_origin_m, half_m), settings))
            return true;
    }
    return false;
}

bool ClearImage::may_look_through(const RangeView& view, const Window& window,
                                  const ViewSettings& settings) const {
    if (window.half_turns >= 0.5f) return true;
    const float z_m = std::max({0.0f, window.z_min_m, -window.z_max_m});
    const float range_m = std::sqrt(window.level_min_m * window.level_min_m + z_m * z_m);
    const auto margin_m = static_cast<float>(settings.margin_m + settings.margin_per_m * range_m);
    const auto beyond = static_cast<int>((range_m + margin_m) / RangeView::range_unit_m);

    const auto off = static_cast<float>(settings.sigma_slope);
    const float steepest = window.z_max_m / (window.z_max_m > 0 ? window.level_min_m : window.level_max_m);
    const float lowest = window.z_min_m / (window.z_min_m > 0 ? window.level_max_m : window.level_min_m);
    const int upper = std::max(0, view.ring_above(steepest + off)), last = view.ring_above(lowest + off);
    if (last < 0) return false;  // above all rings
    int lower = last + 1;
    while (lower + 1 < view.rings() && view.slopes_[static_cast<std::size_t>(lower)] > lowest - off) ++lower;
    lower = std::min(lower, view.rings() - 1);

    const auto columns = static_cast<float>(columns_);
    const int from = static_cast<int>(std::floor((window.turns - window.half_turns) * columns)),
              to = static_cast<int>(std::floor((window.turns + window.half_turns) * columns));
    // All beams of look()'s rows must have gone beyond, so those of each pair among them.
    for (int row = upper; row < lower; ++row)
        if (any_beyond(row, from, to, beyond)) return true;
    return false;
}

bool ClearImage::any_beyond(int row, int first, int last, int range) const {
    if (first < 0)
        return any_beyond(row, first + columns_, columns_ - 1, range) || any_beyond(row, 0, last, range);
    if (last >= columns_)
        return any_beyond(row, first, columns_ - 1, range) || any_beyond(row, 0, last - columns_, range);
    const std::uint16_t* clear = &clear_[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_)];
    const std::uint16_t* farthest =
        &farthest_[static_cast<std::size_t>(row) * static_cast<std::size_t>(groups_)];
    for (int c = first; c <= last;) {
        const int next = (c / group + 1) * group;
        if (farthest[c / group] > range)
            for (const int end = std::min(next, last + 1); c < end; ++c)
                if (clear[c] > range) return true;
        c = next;
    }
    return false;
}

}  // namespace loopline::cloud_map
