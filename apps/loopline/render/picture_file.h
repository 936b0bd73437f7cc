/// A picture as a file.
#pragma once

#include <filesystem>
#include <opencv2/core.hpp>

namespace loopline {

/// BGR. Throws CommandError if the file can't be written.
void write_png(const cv::Mat& picture, const std::filesystem::path& file);

}  // namespace loopline
