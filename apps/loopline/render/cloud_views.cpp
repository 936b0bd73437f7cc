#include "render/cloud_views.h"

#include <algorithm>
#include <cmath>

#include "render/cloud_splat.h"
#include "render/figure.h"
#include "render/plan_views.h"
#include "render/scale.h"
#include "render/view_camera.h"

namespace loopline {
namespace {

/// Rows are a picture's right, its up and the direction to the eye, in the map frame.
Eigen::Matrix3d axes_of_view(bool from_above) {
    Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
    if (from_above) return axes;
    ViewCamera camera;
    camera.azimuth_deg = -65;
    camera.elevation_deg = 48;
    axes << camera.right().transpose(), camera.up().transpose(), camera.direction_to_eye().transpose();
    return axes;
}

/// What a picture must show: the path with its surroundings, and of the cloud all but its far ends, where a
/// few beams got through a gap.
Bounds bounds_in(const SceneContent& content, const Eigen::Matrix3d& axes) {
    constexpr double far_ends = 0.004;
    Bounds bounds = bounds_of_cloud(*content.cloud, axes, far_ends);
    for (const Pose3& pose : content.estimated_path) bounds.add(axes * pose.translation_m);
    return bounds;
}

ParallelView view_into(const MapWindow& window, const Eigen::Matrix3d& axes, double px_per_m) {
    Eigen::Matrix3d linear = axes;
    linear.row(0) *= px_per_m;
    linear.row(1) *= -px_per_m;
    const Eigen::Vector3d offset(-px_per_m * window.left_m(), px_per_m * window.top_m(), 0);
    return {linear.cast<float>(), offset.cast<float>()};
}

/// Wide enough that neighbouring points of a dense cloud touch each other.
int side_of_points_px(double px_per_m) {
    constexpr double apart_m = 0.14;
    return std::clamp(static_cast<int>(std::ceil(apart_m * px_per_m)), 2, 6);
}

/// Heights of all but the lowest and highest percent: a chimney must not make the street all one colour.
HeightColours colours_of(const PointSource& cloud) {
    HeightColours colours;
    const Bounds bounds = bounds_of_cloud(cloud, Eigen::Matrix3d::Identity(), 0.01);
    if (bounds.empty()) return colours;
    colours.lowest_m = bounds.low_m.z();
    colours.highest_m = std::max(bounds.high_m.z(), colours.lowest_m + 0.1);
    return colours;
}

/// A part of the path, hidden by what stands before it or not.
struct Stretch {
    bool hidden = false;
    Pixels path;
};

std::vector<Stretch> stretches_of(const SceneContent& content, const MapWindow& window,
                                  const Eigen::Matrix3d& axes, const cv::Mat1f& depth_m) {
    constexpr double before_m =
        2.5;  // by which the surface is nearer to the eye: the vehicle stands up from it
    std::vector<Stretch> stretches;
    Eigen::Vector2d last(INFINITY, INFINITY);
    for (const Pose3& pose : content.estimated_path) {
        const Eigen::Vector3d p = axes * pose.translation_m;
        const Eigen::Vector2d pixel = window.pixel(p.head<2>());
        if ((pixel - last).norm() < 0.5) continue;
        const int column = static_cast<int>((pixel.x() - window.box.x) * Canvas::supersampling),
                  row = static_cast<int>((pixel.y() - window.box.y) * Canvas::supersampling);
        const bool inside = column >= 0 && row >= 0 && column < depth_m.cols && row < depth_m.rows;
        const bool hidden = inside && depth_m(row, column) > p.z() + before_m;
        if (stretches.empty() || stretches.back().hidden != hidden) {
            if (!stretches.empty()) stretches.back().path.push_back(pixel);
            stretches.push_back({hidden, {}});
        }
        stretches.back().path.push_back(pixel);
        last = pixel;
    }
    return stretches;
}

void draw_cloud_path(Figure& figure, const MapWindow& window, const SceneContent& content,
                     const Eigen::Matrix3d& axes, const cv::Mat1f& depth_m) {
    if (content.estimated_path.empty()) return;
    const double width_px = 0.17 * figure.body_px();
    const auto stretches = stretches_of(content, window, axes, depth_m);
    for (const Stretch& stretch : stretches)
        if (!stretch.hidden) figure.canvas().polyline(stretch.path, 2 * width_px, palette::paper);
    for (const Stretch& stretch : stretches) {
        if (stretch.hidden)
            figure.canvas().dashed_polyline(stretch.path, 0.7 * width_px, 4 * width_px, palette::end);
        else
            figure.canvas().polyline(stretch.path, width_px, palette::end);
    }
    const auto mark = [&](Mark kind, const Pose3& pose) {
        figure.mark(kind, window.pixel((axes * pose.translation_m).head<2>()), 0.45 * figure.body_px());
    };
    mark(Mark::end, content.estimated_path.back());
    mark(Mark::start, content.estimated_path.front());
}

cv::Mat draw_cloud_view(const SceneContent& content, PictureSize size, bool from_above) {
    const Eigen::Matrix3d axes = axes_of_view(from_above);
    const HeightColours colours = colours_of(*content.cloud);
    Figure::Text text;
    text.title = content.title;
    text.subtitle = content_summary(content);
    text.axes = from_above;
    text.panel_titles = {""};
    if (!content.estimated_path.empty())
        text.legend = {{Mark::line, "Path", palette::end},
                       {Mark::start, "Start", palette::start},
                       {Mark::end, "End", palette::end}};
    text.colour_bar = ColourBar{colours.lowest_m, colours.highest_m};
    if (!from_above) text.scale_note = " across";
    Figure figure(size, text);
    const MapWindow window = fitting_window(bounds_in(content, axes), figure.panel(0));
    figure.canvas().clip(window.box);
    if (from_above) figure.graticule(window);
    cv::Mat pixels = figure.canvas().drawn_pixels(window.box);
    const double px_per_m = window.px_per_m * Canvas::supersampling;
    const cv::Mat1f depth_m = splat_cloud(pixels, *content.cloud, view_into(window, axes, px_per_m), colours,
                                          side_of_points_px(px_per_m));
    draw_cloud_path(figure, window, content, axes, depth_m);
    figure.canvas().unclip();
    figure.frame(0);
    if (from_above) figure.tick_labels(window, true);
    figure.scale_bar(window.px_per_m);
    return figure.finish();
}

}  // namespace

cv::Mat draw_cloud_top(const SceneContent& content, PictureSize size) {
    return draw_cloud_view(content, size, true);
}

cv::Mat draw_cloud_axonometric(const SceneContent& content, PictureSize size) {
    return draw_cloud_view(content, size, false);
}

PictureSize cloud_picture_size(const SceneContent& content, bool from_above) {
    const Bounds bounds = bounds_in(content, axes_of_view(from_above));
    if (bounds.empty()) return {};
    const Eigen::Vector3d extent_m = bounds.extent_m().cwiseMax(1.0);
    constexpr int width_px = 1600, furniture_px = 150, beside_px = 130;
    const double map_px = (width_px - beside_px) * extent_m.y() / extent_m.x();
    if (map_px <= 1300) return {width_px, static_cast<int>(std::max(map_px, 300.0)) + furniture_px};
    const double narrow_px = 1300 * extent_m.x() / extent_m.y();
    return {static_cast<int>(std::max(narrow_px, 500.0)) + beside_px, 1300 + furniture_px};
}

}  // namespace loopline
