/// Off-screen rendering by MRPT's CFBORender, with its traps walled in: see the .cpp.
#pragma once

#include <mrpt/opengl/COpenGLScene.h>

#include <opencv2/core.hpp>

#include "render/view_camera.h"

namespace loopline {

/// `scene`, made for this one call, as the camera sees it; BGR, white where there is nothing. OpenGL is
/// started by the first call in a thread and never otherwise. Throws CommandError if this machine can't
/// render.
cv::Mat render_offscreen(mrpt::opengl::COpenGLScene& scene, const ViewCamera& camera, int width_px,
                         int height_px);

}  // namespace loopline
