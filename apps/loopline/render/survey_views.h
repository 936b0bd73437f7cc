/// The survey cloud by dead reckoning and by the corrected poses, from above and aside: Hu 2012, figure 7.
#pragma once

#include <opencv2/core.hpp>

#include "render/picture_size.h"
#include "render/scene_content.h"

namespace loopline {

/// BGR. The first survey of the content, both clouds at one scale; a ceiling is taken off.
cv::Mat draw_survey_top(const SceneContent& content, PictureSize size);
cv::Mat draw_survey_axonometric(const SceneContent& content, PictureSize size);

/// Wide clouds lie one above the other in an upright picture, others side by side.
PictureSize survey_picture_size(const SceneContent& content);

}  // namespace loopline
