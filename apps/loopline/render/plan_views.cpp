/// Composition of the plans: what is drawn in which order, and what the legend says.
#include "render/plan_views.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "render/content_bounds.h"
#include "render/figure.h"
#include "render/plan.h"
#include "render/scale.h"

namespace loopline {
namespace {

/// Points that rise above the ground by more than this are worth a colour by height.
constexpr double flat_m = 0.5;

PointStyle style_of(const std::vector<Eigen::Vector3f>& points_m) {
    PointStyle style;
    const Bounds bounds = bounds_of_points(points_m);
    if (bounds.empty() || bounds.extent_m().z() < flat_m) return style;
    style.by_height = true;
    style.lowest_m = bounds.low_m.z();
    style.highest_m = bounds.high_m.z();
    return style;
}

LegendEntry points_entry(const PointStyle& style) {
    if (!style.by_height) return {Mark::points, "Scan points", style.colour};
    const double step = 0.1;
    return {Mark::heights,
            "Height " + tick_text(style.lowest_m, step) + " to " + tick_text(style.highest_m, step) + " m",
            {}};
}

std::optional<Eigen::Vector2d> first_point(const std::vector<Pose3>& path) {
    for (const auto& pose : path)
        if (pose.translation_m.allFinite()) return pose.translation_m.head<2>();
    return std::nullopt;
}

std::optional<Eigen::Vector2d> last_point(const std::vector<Pose3>& path) {
    for (auto pose = path.rbegin(); pose != path.rend(); ++pose)
        if (pose->translation_m.allFinite()) return pose->translation_m.head<2>();
    return std::nullopt;
}

void mark_point(Figure& figure, const MapWindow& window, Mark mark,
                const std::optional<Eigen::Vector2d>& p_map) {
    if (p_map) figure.mark(mark, window.pixel(*p_map), 0.45 * figure.body_px());
}

}  // namespace

double path_length_m(const std::vector<Pose3>& path) {
    double length_m = 0;
    for (std::size_t i = 1; i < path.size(); ++i) {
        const double step_m = (path[i].translation_m - path[i - 1].translation_m).norm();
        if (std::isfinite(step_m)) length_m += step_m;
    }
    return length_m;
}

std::string content_summary(const SceneContent& content) {
    std::string text;
    const auto add = [&](const std::string& part) { text += (text.empty() ? "" : "  \u00b7  ") + part; };
    char number[48];
    if (!content.estimated_path.empty() || !content.odometry_path.empty()) {
        const bool is_estimate = !content.estimated_path.empty();
        const double length_m = path_length_m(is_estimate ? content.estimated_path : content.odometry_path);
        std::snprintf(number, sizeof number,
                      length_m < 100     ? "%.1f m"
                      : length_m < 10000 ? "%.0f m"
                                         : "%.1f km",
                      length_m < 10000 ? length_m : length_m / 1000);
        add(std::string(is_estimate ? "path " : "dead reckoning ") + number);
        add(grouped(is_estimate ? content.estimated_path.size() : content.odometry_path.size()) + " poses");
    }
    if (content.lines && !content.lines->empty())
        add(grouped(content.lines->size()) + (content.lines->size() == 1 ? " wall" : " walls"));
    if (!content.points_m.empty()) add(grouped(content.points_m.size()) + " points");
    if (content.cloud) add(grouped(content.cloud->size()) + " points");
    if (content.grid) {
        std::snprintf(number, sizeof number, "%.3g cm", content.grid->getResolution() * 100);
        add(std::string("grid of ") + number);
    }
    return text;
}

cv::Mat draw_top_view(const SceneContent& content, PictureSize size) {
    const PointStyle style = style_of(content.points_m);
    Figure::Text text;
    text.title = content.title;
    text.subtitle = content_summary(content);
    text.axes = true;
    const bool has_lines = content.lines && !content.lines->empty();
    if (!content.estimated_path.empty())
        text.legend.push_back({Mark::line, "Estimated path", palette::estimate});
    if (!content.odometry_path.empty())
        text.legend.push_back({Mark::dashed_line, "Dead reckoning", palette::dead_reckoning});
    if (has_lines) text.legend.push_back({Mark::wall, "Walls", palette::wall});
    if (!content.points_m.empty()) text.legend.push_back(points_entry(style));
    if (content.grid) text.legend.push_back({Mark::occupied, "Free, occupied", {}});
    if (!content.estimated_path.empty()) {
        text.legend.push_back({Mark::start, "Start", palette::start});
        text.legend.push_back({Mark::end, "End", palette::end});
    }

    Figure figure(size, text);
    Canvas& canvas = figure.canvas();
    const double u = figure.body_px();
    const Bounds bounds = bounds_of(content);
    if (bounds.empty()) {
        figure.frame(0);
        figure.message(0, "Nothing to draw");
        return figure.finish();
    }
    const MapWindow window = fitting_window(bounds, figure.panel(0));
    canvas.clip(window.box);
    if (content.grid) draw_grid(canvas, window, *content.grid);
    figure.graticule(window);
    draw_points(canvas, window, content.points_m, style, point_size_px(content.points_m.size(), u));
    if (has_lines) draw_walls(canvas, window, *content.lines, 0.17 * u);
    draw_path(canvas, window, content.odometry_path, palette::dead_reckoning, 0.14 * u, true);
    draw_path(canvas, window, content.estimated_path, palette::estimate, 0.17 * u, false);
    mark_point(figure, window, Mark::dead_reckoning_end, last_point(content.odometry_path));
    mark_point(figure, window, Mark::end, last_point(content.estimated_path));
    mark_point(figure, window, Mark::start, first_point(content.estimated_path));
    canvas.unclip();
    figure.frame(0);
    figure.tick_labels(window, true);
    figure.scale_bar(window.px_per_m);
    return figure.finish();
}

cv::Mat draw_before_after(const SceneContent& content, PictureSize size) {
    Figure::Text text;
    text.title = content.title;
    text.subtitle = content_summary(content);
    text.axes = true;
    text.panel_titles = {"Before: dead reckoning", "After: the estimate"};
    text.legend = {{Mark::dashed_line, "Dead reckoning", palette::dead_reckoning},
                   {Mark::line, "Estimated path", palette::estimate},
                   {Mark::points, "Scan points", palette::scan_point},
                   {Mark::start, "Start", palette::start},
                   {Mark::end, "End", palette::end}};
    Figure figure(size, text);
    Canvas& canvas = figure.canvas();
    const double u = figure.body_px();

    Bounds bounds = bounds_of(content);
    bounds.add(bounds_of_points(content.points_odometry_m));
    for (std::size_t panel = 0; panel < 2; ++panel) {
        const bool before = panel == 0;
        const auto& path = before ? content.odometry_path : content.estimated_path;
        const auto& points_m = before ? content.points_odometry_m : content.points_m;
        const MapWindow window = fitting_window(bounds, figure.panel(panel));
        canvas.clip(window.box);
        figure.graticule(window);
        draw_points(canvas, window, points_m, {}, std::max(1.0, 0.07 * u));
        draw_path(canvas, window, path, before ? palette::dead_reckoning : palette::estimate, 0.14 * u,
                  before);
        mark_point(figure, window, Mark::end, last_point(path));
        mark_point(figure, window, Mark::start, first_point(path));
        canvas.unclip();
        figure.frame(panel);
        figure.tick_labels(window, panel == 0 || figure.panel(0).y != figure.panel(1).y);
        if (path.empty() && points_m.empty())
            figure.message(panel, before ? "No dead reckoning in this run" : "No estimate in this run");
        if (panel == 0) figure.scale_bar(window.px_per_m);
    }
    return figure.finish();
}

}  // namespace loopline
