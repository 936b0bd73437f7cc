/// Size of a picture, and what sizes are allowed.
#pragma once

namespace loopline {

struct PictureSize {
    int width_px = 1280;
    int height_px = 960;
};

inline constexpr int smallest_picture_px = 64;  ///< below it nothing can be told apart
inline constexpr int largest_picture_px =
    8192;  ///< drawn at twice the size, which the off-screen renderer still takes

inline bool is_allowed(PictureSize size) {
    return size.width_px >= smallest_picture_px && size.width_px <= largest_picture_px &&
           size.height_px >= smallest_picture_px && size.height_px <= largest_picture_px;
}

}  // namespace loopline
