/// What closing a loop did: the map before and after, whole and near the place of the loop.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "api/results.h"
#include "render/picture_size.h"

namespace loopline {

/// A correction, with what is said about it.
struct CorrectionContent {
    const PathCorrection& correction;
    FramePoints frame_points_base_m;  ///< may be of fewer frames, or more
    std::string title;
    std::string subtitle;
};

/// BGR. Close-ups below the maps where the misclosure is small against them.
cv::Mat draw_correction(const CorrectionContent& content, PictureSize size);

/// As high as the shape of the map asks for.
PictureSize correction_picture_size(const CorrectionContent& content);

/// "0.42 m and 1.3°".
std::string misclosure_text(const Pose2& T_before_after);
/// How far the misclosure moves what is seen, in m: a turn moves walls 5 m away too.
double misclosure_size_m(const Pose2& T_before_after);

}  // namespace loopline
