/// What CFBORender of MRPT 2.5.8 needs to give right pictures without a display:
/// - Mesa's software renderer runs MRPT's "mediump" shaders in half precision on processors with f16c, which
/// ruins depth:
///   the capability is masked before EGL starts.
/// - It writes beyond the image if the width is not a multiple of 4.
/// - Two renderers in one thread, or one scene in two renderers, fail: each thread keeps one, and makes a
/// larger one (after
///   the old is gone) when it must.
/// - It has no antialiasing: pictures are rendered twice as large and averaged down.
#include "render/offscreen.h"

#include <mrpt/img/CImage.h>
#include <mrpt/opengl/CFBORender.h>

#include <algorithm>
#include <cstdlib>
#include <memory>
#include <opencv2/imgproc.hpp>

#include "commands/command.h"

namespace loopline {
namespace {

constexpr int largest_buffer_px = 16384;

struct Renderer {
    int width_px = 0, height_px = 0;
    std::unique_ptr<mrpt::opengl::CFBORender> fbo;
};

mrpt::opengl::CFBORender& renderer_for(int width_px, int height_px, int& buffer_height_px) {
    thread_local Renderer renderer;
    if (!renderer.fbo || width_px > renderer.width_px || height_px > renderer.height_px) {
        setenv("GALLIUM_OVERRIDE_CPU_CAPS", "sse4.1", 0);
        renderer.fbo.reset();
        renderer.width_px = std::max(renderer.width_px, (width_px + 3) / 4 * 4);
        renderer.height_px = std::max(renderer.height_px, height_px);
        renderer.fbo = std::make_unique<mrpt::opengl::CFBORender>(renderer.width_px, renderer.height_px);
    }
    buffer_height_px = renderer.height_px;
    return *renderer.fbo;
}

mrpt::opengl::CCamera mrpt_camera(const ViewCamera& view, int width_px, int height_px) {
    mrpt::opengl::CCamera camera;
    camera.setAzimuthDegrees(static_cast<float>(view.azimuth_deg));
    camera.setElevationDegrees(static_cast<float>(view.elevation_deg));
    camera.setProjectiveModel(!view.parallel);
    camera.setProjectiveFOVdeg(static_cast<float>(view.field_of_view_deg));
    Eigen::Vector3d pointing_m = view.target_m;
    double eye_distance_m = view.distance_m;
    if (view.parallel) {
        // MRPT shows half the eye distance over the shorter edge. That fixes the eye distance, so the point
        // looked at moves along the line of sight to put the eye where it should be.
        eye_distance_m = 2 * view.visible_height_m * std::min(1.0, static_cast<double>(width_px) / height_px);
        pointing_m += (view.distance_m - eye_distance_m) * view.direction_to_eye();
    }
    camera.setZoomDistance(static_cast<float>(eye_distance_m));
    camera.setPointingAt(static_cast<float>(pointing_m.x()), static_cast<float>(pointing_m.y()),
                         static_cast<float>(pointing_m.z()));
    return camera;
}

}  // namespace

cv::Mat render_offscreen(mrpt::opengl::COpenGLScene& scene, const ViewCamera& camera, int width_px,
                         int height_px) {
    const int scale = std::max(width_px, height_px) * 2 <= largest_buffer_px ? 2 : 1;
    const int drawn_width_px = width_px * scale, drawn_height_px = height_px * scale;
    try {
        int buffer_height_px = 0;
        auto& fbo = renderer_for(drawn_width_px, drawn_height_px, buffer_height_px);
        auto viewport = scene.getViewport();
        viewport->setCustomBackgroundColor({1.f, 1.f, 1.f});
        viewport->setViewportClipDistances(static_cast<float>(camera.near_m),
                                           static_cast<float>(camera.far_m));
        viewport->setViewportPosition(0, 0, drawn_width_px, drawn_height_px);
        auto& light = viewport->lightParameters();
        light.ambient = {0.72f, 0.72f, 0.72f, 1.f};
        light.diffuse = {0.42f, 0.42f, 0.42f, 1.f};
        light.specular = {0.f, 0.f, 0.f, 1.f};
        fbo.setCamera(scene, mrpt_camera(camera, drawn_width_px, drawn_height_px));
        mrpt::img::CImage image;
        fbo.render_RGB(scene, image);
        // OpenGL's origin is the lower left corner; the rest of a larger buffer holds older pictures.
        const cv::Mat drawn =
            image.asCvMatRef()({0, buffer_height_px - drawn_height_px, drawn_width_px, drawn_height_px});
        cv::Mat picture;
        cv::resize(drawn, picture, {width_px, height_px}, 0, 0, cv::INTER_AREA);
        return picture;
    } catch (const std::exception&) {
        throw CommandError(exit_configuration,
                           "Spatial pictures can't be rendered on this machine: OpenGL through EGL does not "
                           "start; is libgl1-mesa-dri installed?");
    }
}

}  // namespace loopline
