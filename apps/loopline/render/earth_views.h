/// Pictures of a path on the Earth: what the fixes of a receiver made of the motion alone, as in Yu, Zheng,
/// Ou and Wang 2022, figures 9 to 11.
#pragma once

#include <opencv2/core.hpp>

#include "render/earth_content.h"
#include "render/picture_size.h"
#include "render/scene_content.h"

namespace loopline {

/// From above, over what `map` has of points or a grid: the path with and without fixes, the truth, the
/// fixes.
cv::Mat draw_earth_plan(const EarthContent& content, const SceneContent& map, PictureSize size);
/// Heights above the ellipsoid over the way.
cv::Mat draw_earth_heights(const EarthContent& content, PictureSize size);
/// Errors over time in bands of three standard deviations: east, north, up, heading. Only with a truth.
cv::Mat draw_earth_errors(const EarthContent& content, PictureSize size);

}  // namespace loopline
