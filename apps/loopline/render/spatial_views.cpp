/// Scene and camera for each view; the figure round them is the plan's.
#include "render/spatial_views.h"

#include <mrpt/opengl/CSetOfTriangles.h>

#include <algorithm>

#include "render/content_bounds.h"
#include "render/figure.h"
#include "render/offscreen.h"
#include "render/plan_views.h"
#include "render/scale.h"
#include "render/solids.h"
#include "render/spatial_scene.h"

namespace loopline {
namespace {

Figure::Text text_for(const SceneContent& content, const std::string& where_scale_holds) {
    Figure::Text text;
    text.scale_note = " " + where_scale_holds;
    text.title = content.title;
    text.subtitle = content_summary(content);
    if (!content.estimated_path.empty())
        text.legend.push_back({Mark::line, "Estimated path", palette::estimate});
    if (!content.odometry_path.empty())
        text.legend.push_back({Mark::line, "Dead reckoning", palette::dead_reckoning});
    if (content.lines && !content.lines->empty())
        text.legend.push_back({Mark::wall, "Walls, raised", {150, 160, 172}});
    if (const Bounds points = bounds_of_points(content.points_m); !points.empty()) {
        if (points.extent_m().z() > 0.5)
            text.legend.push_back({Mark::heights,
                                   "Height " + tick_text(points.low_m.z(), 0.1) + " to " +
                                       tick_text(points.high_m.z(), 0.1) + " m",
                                   {}});
        else
            text.legend.push_back({Mark::points, "Scan points", palette::scan_point});
    }
    if (!content.estimated_path.empty()) {
        text.legend.push_back({Mark::start, "Start", palette::start});
        text.legend.push_back({Mark::end, "End", palette::end});
    }
    return text;
}

/// Renders into the figure's only panel; the drawn pixels are twice as large as the rendered ones.
void place(Figure& figure, mrpt::opengl::COpenGLScene& scene, const ViewCamera& camera) {
    const Box& box = figure.panel(0);
    cv::Mat target = figure.canvas().drawn_pixels(box);
    constexpr int s = Canvas::supersampling;
    const cv::Mat rendered = render_offscreen(scene, camera, target.cols / s, target.rows / s);
    for (int y = 0; y < target.rows; ++y)
        for (int x = 0; x < target.cols; ++x)
            target.at<cv::Vec3b>(y, x) = rendered.at<cv::Vec3b>(std::min(y / s, rendered.rows - 1),
                                                                std::min(x / s, rendered.cols - 1));
    figure.frame(0);
}

cv::Mat nothing_to_draw(Figure& figure, const std::string& sentence) {
    figure.frame(0);
    figure.message(0, sentence);
    return figure.finish();
}

}  // namespace

cv::Mat draw_axonometric_view(const SceneContent& content, PictureSize size) {
    Figure figure(size, text_for(content, "across"));
    if (bounds_of(content).empty()) return nothing_to_draw(figure, "Nothing to draw");
    const SceneSizes sizes = sizes_for_overview(content);
    const Box& box = figure.panel(0);
    const ViewCamera camera = axonometric_camera(content, sizes.wall_height_m, box.width, box.height);
    place(figure, *make_spatial_scene(content, sizes), camera);
    figure.scale_bar(camera.px_per_m(box.height));
    return figure.finish();
}

cv::Mat draw_follow_view(const SceneContent& content, PictureSize size) {
    Figure figure(size, text_for(content, "at the vehicle"));
    const auto& path = content.estimated_path.empty() ? content.odometry_path : content.estimated_path;
    const auto last = std::find_if(path.rbegin(), path.rend(), [](const Pose3& pose) {
        return pose.translation_m.allFinite() && pose.rotation.coeffs().allFinite();
    });
    if (last == path.rend()) return nothing_to_draw(figure, "No pose to look from");
    const ViewCamera camera = follow_camera(*last, bounds_of(content));

    SceneSizes sizes;
    sizes.wall_height_m = 0.22 * camera.distance_m;
    sizes.wall_thickness_m = 0.008 * camera.distance_m;
    sizes.path_radius_m = 0.006 * camera.distance_m;
    sizes.pin_height_m = 0.12 * camera.distance_m;
    sizes.grid_step_m = 1;
    sizes.point_px = 4;
    sizes.end_pin = false;
    // A grid of metres that ran to the horizon would be moire.
    const Eigen::Vector3d reach_m(5 * camera.distance_m, 5 * camera.distance_m, 0);
    sizes.ground.emplace();
    sizes.ground->add(last->translation_m - reach_m);
    sizes.ground->add(last->translation_m + reach_m);
    auto scene = make_spatial_scene(content, sizes);
    auto cart = mrpt::opengl::CSetOfTriangles::Create();
    add_cart(*cart, last->planar(), last->translation_m.z(), palette::end, palette::paper);
    scene->insert(cart);

    place(figure, *scene, camera);
    figure.scale_bar(camera.px_per_m(figure.panel(0).height));
    return figure.finish();
}

}  // namespace loopline
