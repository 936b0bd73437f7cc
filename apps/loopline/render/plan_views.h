/// The two plans: the map from above, and the map before and after.
#pragma once

#include <opencv2/core.hpp>
#include <string>

#include "render/picture_size.h"
#include "render/scene_content.h"

namespace loopline {

/// BGR.
cv::Mat draw_top_view(const SceneContent& content, PictureSize size);
cv::Mat draw_before_after(const SceneContent& content, PictureSize size);

/// "path 76.3 m, 31 walls, 40 213 points": what the content holds, for the line under a title.
std::string content_summary(const SceneContent& content);

/// Length of the path in m, over its finite poses.
double path_length_m(const std::vector<Pose3>& path);

}  // namespace loopline
