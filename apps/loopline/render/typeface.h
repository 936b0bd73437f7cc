/// Text for pictures: DejaVu Sans through FreeType, or OpenCV's stroke font where no font file is installed.
#pragma once

#include <opencv2/core.hpp>
#include <string>

#include "render/palette.h"

namespace loopline {

enum class Weight { regular, bold };
enum class Align { left, centre, right };

/// Width of one line of UTF-8 text in pixels; `size_px` is the em.
double text_width_px(const std::string& text, double size_px, Weight weight = Weight::regular);

/// Draws one line of UTF-8 text on a BGR image. `x_px` is the left end, centre or right end, `baseline_px`
/// the height of the baseline from the top. What falls outside is cut off.
void draw_text(cv::Mat& bgr, const std::string& text, double x_px, double baseline_px, double size_px,
               Colour colour, Weight weight = Weight::regular, Align align = Align::left);

/// `text`, or as much of its start as fits in `width_px`, ended by an ellipsis.
std::string fitting_text(const std::string& text, double width_px, double size_px,
                         Weight weight = Weight::regular);

}  // namespace loopline
