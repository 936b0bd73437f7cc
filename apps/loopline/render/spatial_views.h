/// The two spatial pictures: the whole map in axonometry, and the view that follows the vehicle.
#pragma once

#include <opencv2/core.hpp>

#include "render/picture_size.h"
#include "render/scene_content.h"

namespace loopline {

/// BGR. Throw CommandError if this machine can't render.
cv::Mat draw_axonometric_view(const SceneContent& content, PictureSize size);
cv::Mat draw_follow_view(const SceneContent& content, PictureSize size);

}  // namespace loopline
