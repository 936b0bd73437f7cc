/// A drawing surface with antialiased shapes in sub-pixel coordinates: everything is drawn at twice the size
/// and averaged down by area at the end; text is set afterwards at the final size.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "render/palette.h"
#include "render/typeface.h"

namespace loopline {

using Pixels =
    std::vector<Eigen::Vector2d>;  ///< picture coordinates: x right, y down, (0, 0) the upper left corner

/// A rectangle of the picture.
struct Box {
    double x = 0, y = 0, width = 0, height = 0;
    double right() const { return x + width; }
    double bottom() const { return y + height; }
    Eigen::Vector2d centre() const { return {x + width / 2, y + height / 2}; }
};

class Canvas {
 public:
    /// Drawn pixels per final pixel, in each direction.
    static constexpr int supersampling = 2;

    Canvas(int width_px, int height_px, Colour background);

    int width_px() const { return width_px_; }
    int height_px() const { return height_px_; }

    void polyline(const Pixels& points, double width_px, Colour colour);
    /// Dashes and gaps of the given length, measured along the line.
    void dashed_polyline(const Pixels& points, double width_px, double dash_px, Colour colour);
    void polygon(const Pixels& corners, Colour colour);
    /// With a light border and a head that is no longer than the arrow.
    void arrow(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double width_px, Colour colour);
    void disc(const Eigen::Vector2d& centre, double radius_px, Colour colour);
    void fill(const Box& box, Colour colour, double opacity = 1);
    void outline(const Box& box, double width_px, Colour colour);
    void text(const std::string& text, double x_px, double baseline_px, double size_px, Colour colour,
              Weight weight = Weight::regular, Align align = Align::left);

    /// Shapes drawn from now on stay inside `box`.
    void clip(const Box& box);
    void unclip();

    /// The drawn pixels under `box`, `supersampling` times as large, to be changed in place.
    cv::Mat drawn_pixels(const Box& box);

    /// The finished picture, BGR.
    cv::Mat finish() const;

 private:
    struct TextItem {
        std::string text;
        double x_px, baseline_px, size_px;
        Colour colour;
        Weight weight;
        Align align;
    };

    cv::Rect drawn_rectangle(const Box& box) const;
    std::vector<cv::Point> fixed_point(const Pixels& points) const;

    int width_px_, height_px_;
    cv::Mat drawn_;                                        ///< BGR, `supersampling` times the size
    cv::Mat target_;                                       ///< the part of `drawn_` that is not clipped away
    Eigen::Vector2d origin_px_ = Eigen::Vector2d::Zero();  ///< of `target_`
    std::vector<TextItem> texts_;
};

/// The vertices of a path that matter at picture scale: those nearer than `spacing_px` to the last one kept
/// are left out. Non-finite vertices are dropped.
Pixels thinned(const Pixels& path, double spacing_px);

}  // namespace loopline
