#include "render/survey_views.h"

#include <algorithm>
#include <cmath>

#include "render/cloud_splat.h"
#include "render/figure.h"
#include "render/plan_views.h"
#include "render/scale.h"
#include "render/view_camera.h"

namespace loopline {
namespace {

struct Side {
    const char* title;
    const char* nothing;
    mrpt::maps::CPointsMap::Ptr cloud;
    const std::vector<Pose3>* path;
    Colour colour;
    Mark end;
};

std::vector<Side> sides_of(const SceneContent& content) {
    const SurveyCloud cloud = content.surveys.empty() ? SurveyCloud{} : content.surveys.front();
    return {{"Before: poses by dead reckoning", "No cloud by dead reckoning", cloud.raw,
             &content.odometry_path, palette::dead_reckoning, Mark::dead_reckoning_end},
            {"After: corrected poses", "No cloud by the estimate", cloud.corrected, &content.estimated_path,
             palette::end, Mark::end}};
}

/// Where a picture looks from: rows are its right, its up and the direction to the eye, in the map frame.
struct Direction {
    Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
    bool from_above = true;
};

Direction axonometric_direction() {
    ViewCamera camera;
    camera.azimuth_deg = -65;
    camera.elevation_deg = 55;
    Direction direction{{}, false};
    direction.axes << camera.right().transpose(), camera.up().transpose(),
        camera.direction_to_eye().transpose();
    return direction;
}

Bounds bounds_of_sides(const std::vector<Side>& sides, const Eigen::Matrix3d& axes) {
    Bounds bounds;
    for (const Side& side : sides) {
        if (side.cloud) bounds.add(bounds_of_cloud(PointsOfMap(*side.cloud), axes));
        for (const Pose3& pose : *side.path) bounds.add(axes * pose.translation_m);
    }
    return bounds;
}

/// From the map to the drawn pixels of a window's box.
ParallelView view_into(const MapWindow& window, const Direction& direction) {
    const double scale = window.px_per_m * Canvas::supersampling;
    Eigen::Matrix3d linear = direction.axes;
    linear.row(0) *= scale;
    linear.row(1) *= -scale;
    const Eigen::Vector3d offset(-scale * window.left_m(), scale * window.top_m(), 0);
    return {linear.cast<float>(), offset.cast<float>()};
}

void draw_cloud(Canvas& canvas, const MapWindow& window, const Direction& direction,
                const mrpt::maps::CPointsMap& cloud, const HeightColours& colours) {
    cv::Mat pixels = canvas.drawn_pixels(window.box);
    splat_cloud(pixels, PointsOfMap(cloud), view_into(window, direction), colours);
}

void draw_path(Figure& figure, const MapWindow& window, const Side& side) {
    if (side.path->empty()) return;
    Pixels path;
    for (const Pose3& pose : *side.path) path.push_back(window.pixel(pose.translation_m.head<2>()));
    path = thinned(path, 0.5);
    const double width_px = 0.13 * figure.body_px();
    figure.canvas().polyline(path, 2 * width_px, palette::paper);
    figure.canvas().polyline(path, width_px, side.colour);
    figure.mark(side.end, path.back(), 0.4 * figure.body_px());
    figure.mark(Mark::start, path.front(), 0.4 * figure.body_px());
}

std::string subtitle_of(const mrpt::maps::CPointsMap::Ptr& cloud, const HeightColours& colours) {
    std::string text = cloud ? grouped(cloud->size()) + " points of the survey laser" : "no survey cloud";
    if (std::isfinite(colours.cut_m))
        text += ", cut below the ceiling at " + tick_text(colours.cut_m, 0.1) + " m";
    return text;
}

cv::Mat draw(const SceneContent& content, PictureSize size, const Direction& direction) {
    const auto sides = sides_of(content);
    const auto& reference = sides[1].cloud ? sides[1].cloud : sides[0].cloud;
    const HeightColours colours = reference ? height_colours(PointsOfMap(*reference)) : HeightColours{};
    Figure::Text text;
    text.title = content.title + (direction.from_above ? ": survey from above" : ": survey, axonometric");
    text.subtitle = subtitle_of(reference, colours);
    text.axes = direction.from_above;
    for (const Side& side : sides) text.panel_titles.push_back(side.title);
    if (direction.from_above)  // from aside, walls hide the ground
        text.legend = {{Mark::line, "Path, dead reckoning", palette::dead_reckoning},
                       {Mark::line, "Path, corrected", palette::end},
                       {Mark::start, "Start", palette::start},
                       {Mark::end, "End", palette::end}};
    text.colour_bar = ColourBar{colours.lowest_m, colours.highest_m};
    if (!direction.from_above) text.scale_note = " across";
    Figure figure(size, text);

    const Bounds bounds = bounds_of_sides(sides, direction.axes);
    for (std::size_t panel = 0; panel < sides.size(); ++panel) {
        const MapWindow window = fitting_window(bounds, figure.panel(panel));
        figure.canvas().clip(window.box);
        if (direction.from_above) figure.graticule(window);
        if (sides[panel].cloud) draw_cloud(figure.canvas(), window, direction, *sides[panel].cloud, colours);
        if (direction.from_above) draw_path(figure, window, sides[panel]);
        figure.canvas().unclip();
        figure.frame(panel);
        if (direction.from_above)
            figure.tick_labels(window, panel == 0 || figure.panel(0).y != figure.panel(1).y);
        if (!sides[panel].cloud) figure.message(panel, sides[panel].nothing);
        if (panel == 0) figure.scale_bar(window.px_per_m);
    }
    return figure.finish();
}

}  // namespace

cv::Mat draw_survey_top(const SceneContent& content, PictureSize size) {
    return draw(content, size, {});
}

cv::Mat draw_survey_axonometric(const SceneContent& content, PictureSize size) {
    return draw(content, size, axonometric_direction());
}

PictureSize survey_picture_size(const SceneContent& content) {
    const Bounds bounds = bounds_of_sides(sides_of(content), Eigen::Matrix3d::Identity());
    if (bounds.empty()) return {};
    const Eigen::Vector3d extent_m = bounds.extent_m().cwiseMax(1.0);
    const double shape = extent_m.x() / extent_m.y();
    if (shape < 1.3) return {1600, static_cast<int>(std::clamp(800 / shape, 600.0, 1500.0)) + 120};
    return {1280, std::max(1480, static_cast<int>(2 * 1180 / shape)) + 160};
}

}  // namespace loopline
