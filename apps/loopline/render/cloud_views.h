/// The cloud of a map in three dimensions, coloured by height, from above and aside, with the path in it.
#pragma once

#include <opencv2/core.hpp>

#include "render/picture_size.h"
#include "render/scene_content.h"

namespace loopline {

/// BGR. `content.cloud` must be there.
cv::Mat draw_cloud_top(const SceneContent& content, PictureSize size);
cv::Mat draw_cloud_axonometric(const SceneContent& content, PictureSize size);

/// One that the cloud fills, as far as that leaves a picture that is neither a strip nor a tower.
PictureSize cloud_picture_size(const SceneContent& content, bool from_above);

}  // namespace loopline
