#include "render/cloud_splat.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "render/palette.h"

namespace loopline {
namespace {

constexpr float nothing = -INFINITY;

constexpr int shades = 256;

/// What is nearest to the eye in each pixel.
struct Surface {
    cv::Mat1f depth_m;  ///< towards the eye
    cv::Mat1b shade;    ///< by its height
};

Surface nearest_points(cv::Size size, const PointSource& cloud, const ParallelView& view,
                       const HeightColours& colours, int side_px) {
    Surface surface{cv::Mat1f(size, nothing), cv::Mat1b(size, uchar{0})};
    const float right = static_cast<float>(size.width - side_px + 1),
                lower = static_cast<float>(size.height - side_px + 1);
    const auto cut_m = static_cast<float>(colours.cut_m);
    const double per_m = (shades - 1) / std::max(1e-3, colours.highest_m - colours.lowest_m);
    cloud.for_each(1, [&](const Eigen::Vector3f& p_map_m) {
        if (!(p_map_m.z() <= cut_m)) return;
        const Eigen::Vector3f p = view(p_map_m);
        if (!(p.x() >= 0 && p.y() >= 0 && p.x() < right && p.y() < lower)) return;
        const int column = static_cast<int>(p.x()), row = static_cast<int>(p.y());
        const double at = (p_map_m.z() - colours.lowest_m) * per_m;
        const auto shade = static_cast<uchar>(std::clamp(at, 0.0, shades - 1.0));
        for (int r = row; r < row + side_px; ++r) {
            float* depth = surface.depth_m[r] + column;
            for (int c = 0; c < side_px; ++c)
                if (p.z() > depth[c]) {
                    depth[c] = p.z();
                    surface.shade(r, column + c) = shade;
                }
        }
    });
    return surface;
}

/// How much of the light reaches a pixel: less where neighbours are nearer to the eye.
float light_at(const cv::Mat1f& depth_m, int row, int column) {
    constexpr int reach = 3;
    constexpr std::array<std::array<int, 2>, 8> around = {
        {{0, reach}, {0, -reach}, {reach, 0}, {-reach, 0}, {2, 2}, {2, -2}, {-2, 2}, {-2, -2}}};
    constexpr float most_m = 0.6f, darkness_per_m = 1.3f;
    float hidden_m = 0;
    for (const auto& [dy, dx] : around) {
        const int r = row + dy, c = column + dx;
        if (r < 0 || c < 0 || r >= depth_m.rows || c >= depth_m.cols) continue;
        const float nearer_m = depth_m(r, c) - depth_m(row, column);
        if (nearer_m > 0) hidden_m += std::min(nearer_m, most_m);
    }
    return std::exp(-darkness_per_m * hidden_m / 8 * 2);
}

/// The value that a share of the values is below.
float sample_quantile(std::vector<float>& values, double share) {
    const auto at = values.begin() + static_cast<std::ptrdiff_t>(share * double(values.size() - 1));
    std::nth_element(values.begin(), at, values.end());
    return *at;
}

constexpr std::size_t sample_size = 200'000;

}  // namespace

cv::Mat1f splat_cloud(cv::Mat& bgr, const PointSource& cloud, const ParallelView& view,
                      const HeightColours& colours, int side_px) {
    const Surface surface = nearest_points(bgr.size(), cloud, view, colours, side_px);
    std::array<Colour, shades> ramp;
    for (int i = 0; i < shades; ++i) ramp[static_cast<std::size_t>(i)] = palette::height(i / (shades - 1.0));
    for (int row = 0; row < bgr.rows; ++row)
        for (int column = 0; column < bgr.cols; ++column) {
            if (surface.depth_m(row, column) == nothing) continue;
            const Colour& c = ramp[surface.shade(row, column)];
            const float light = light_at(surface.depth_m, row, column);
            bgr.at<cv::Vec3b>(row, column) =
                cv::Vec3b(cv::saturate_cast<uchar>(c.blue * light), cv::saturate_cast<uchar>(c.green * light),
                          cv::saturate_cast<uchar>(c.red * light));
        }
    return surface.depth_m;
}

Bounds bounds_of_cloud(const PointSource& cloud, const Eigen::Matrix3d& axes, double left_out) {
    const std::size_t stride = cloud.size() / sample_size + 1;
    std::array<std::vector<float>, 3> values;
    const Eigen::Matrix3f R = axes.cast<float>();
    cloud.for_each(stride, [&](const Eigen::Vector3f& p_map_m) {
        const Eigen::Vector3f p = R * p_map_m;
        if (p.allFinite())
            for (int axis = 0; axis < 3; ++axis) values[static_cast<std::size_t>(axis)].push_back(p[axis]);
    });
    Bounds bounds;
    if (values[0].empty()) return bounds;
    for (int axis = 0; axis < 3; ++axis) {
        auto& v = values[static_cast<std::size_t>(axis)];
        bounds.low_m[axis] = sample_quantile(v, left_out);
        bounds.high_m[axis] = sample_quantile(v, 1 - left_out);
    }
    return bounds;
}

HeightColours height_colours(const PointSource& cloud) {
    HeightColours colours;
    const Bounds bounds = bounds_of_cloud(cloud, Eigen::Matrix3d::Identity());
    if (bounds.empty()) return colours;
    colours.lowest_m = bounds.low_m.z();
    colours.highest_m = std::max(bounds.high_m.z(), colours.lowest_m + 0.1);

    constexpr double bin_m = 0.05, near_top = 0.2, many_times = 4;
    const double span_m = colours.highest_m - colours.lowest_m;
    std::vector<double> points_at(static_cast<std::size_t>(span_m / bin_m) + 1, 0);
    cloud.for_each(cloud.size() / sample_size + 1, [&](const Eigen::Vector3f& p_map_m) {
        const double bin = std::floor((p_map_m.z() - colours.lowest_m) / bin_m);
        if (bin >= 0 && bin < double(points_at.size())) ++points_at[static_cast<std::size_t>(bin)];
    });
    const auto top =
        points_at.begin() + static_cast<std::ptrdiff_t>((1 - near_top) * double(points_at.size()));
    const auto fullest = std::max_element(top, points_at.end());
    std::vector<double> below(points_at.begin(), top);
    if (below.size() < 5) return colours;
    std::nth_element(below.begin(), below.begin() + static_cast<std::ptrdiff_t>(below.size() / 2),
                     below.end());
    if (*fullest > many_times * std::max(1.0, below[below.size() / 2])) {
        constexpr double under_ceiling_m = 0.15;
        colours.cut_m = colours.lowest_m + bin_m * double(fullest - points_at.begin()) - under_ceiling_m;
        colours.highest_m = colours.cut_m;
    }
    return colours;
}

}  // namespace loopline
