/// Shapes go to OpenCV in fixed-point coordinates of the enlarged image.
#include "render/canvas.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace loopline {
namespace {

constexpr int fraction_bits = 4;  // of OpenCV's fixed-point coordinates
/// OpenCV clips lines by itself, but its coordinates must not overflow an int.
constexpr double far_px = 1e5;

cv::Scalar bgr(Colour colour) {
    return {double(colour.blue), double(colour.green), double(colour.red)};
}

bool is_near(const Eigen::Vector2d& p) {
    return p.array().abs().maxCoeff() < far_px;
}

}  // namespace

Canvas::Canvas(int width_px, int height_px, Colour background)
    : width_px_(width_px),
      height_px_(height_px),
      drawn_(height_px * supersampling, width_px * supersampling, CV_8UC3, bgr(background)),
      target_(drawn_) {}

cv::Rect Canvas::drawn_rectangle(const Box& box) const {
    const int left = static_cast<int>(std::lround(box.x * supersampling));
    const int top = static_cast<int>(std::lround(box.y * supersampling));
    const int right = static_cast<int>(std::lround(box.right() * supersampling));
    const int bottom = static_cast<int>(std::lround(box.bottom() * supersampling));
    return cv::Rect(left, top, std::max(0, right - left), std::max(0, bottom - top)) &
           cv::Rect({}, drawn_.size());
}

void Canvas::clip(const Box& box) {
    const cv::Rect rectangle = drawn_rectangle(box);
    target_ = drawn_(rectangle);
    origin_px_ = Eigen::Vector2d(rectangle.x, rectangle.y) / supersampling;
}

void Canvas::unclip() {
    target_ = drawn_;
    origin_px_.setZero();
}

cv::Mat Canvas::drawn_pixels(const Box& box) {
    return drawn_(drawn_rectangle(box));
}

/// A pixel's centre has integer coordinates in OpenCV, and half ones in ours.
std::vector<cv::Point> Canvas::fixed_point(const Pixels& points) const {
    std::vector<cv::Point> fixed;
    fixed.reserve(points.size());
    for (const auto& p : points) {
        const Eigen::Vector2d q = (((p - origin_px_) * supersampling).array() - 0.5) * (1 << fraction_bits);
        fixed.emplace_back(static_cast<int>(std::lround(q.x())), static_cast<int>(std::lround(q.y())));
    }
    return fixed;
}

void Canvas::polyline(const Pixels& points, double width_px, Colour colour) {
    const int thickness = std::max(1, static_cast<int>(std::lround(width_px * supersampling)));
    Pixels piece;
    const auto draw = [&] {
        if (piece.size() > 1)
            cv::polylines(target_, fixed_point(piece), false, bgr(colour), thickness, cv::LINE_AA,
                          fraction_bits);
        piece.clear();
    };
    for (const auto& p : points)
        if (is_near(p))
            piece.push_back(p);
        else
            draw();
    draw();
}

void Canvas::dashed_polyline(const Pixels& points, double width_px, double dash_px, Colour colour) {
    Pixels dash;
    double left_px = dash_px;
    bool on = true;
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (i == 0 || !is_near(points[i]) || !is_near(points[i - 1])) {
            polyline(dash, width_px, colour);
            dash.assign(1, points[i]);
            continue;
        }
        Eigen::Vector2d from = points[i - 1];
        double rest_px = (points[i] - from).norm();
        while (rest_px > left_px) {
            from += (points[i] - from) * (left_px / rest_px);
            rest_px -= left_px;
            if (on) {
                dash.push_back(from);
                polyline(dash, width_px, colour);
            }
            dash.assign(1, from);
            on = !on;
            left_px = dash_px;
        }
        left_px -= rest_px;
        if (on) dash.push_back(points[i]);
    }
    if (on) polyline(dash, width_px, colour);
}

void Canvas::polygon(const Pixels& corners, Colour colour) {
    if (corners.size() < 3 || !std::all_of(corners.begin(), corners.end(), is_near)) return;
    const std::vector<cv::Point> fixed = fixed_point(corners);
    cv::fillPoly(target_, std::vector<std::vector<cv::Point>>{fixed}, bgr(colour), cv::LINE_AA,
                 fraction_bits);
}

void Canvas::arrow(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double width_px, Colour colour) {
    const double length_px = (to - from).norm();
    if (!(length_px > 0) || !is_near(from) || !is_near(to)) return;
    const Eigen::Vector2d along = (to - from) / length_px, across(-along.y(), along.x());
    const double head_px = std::min(length_px, 4.5 * width_px);
    const auto draw = [&](double border_px, Colour ink) {
        const Eigen::Vector2d tip = to + 2 * border_px * along, base = to - (head_px + border_px) * along;
        const Eigen::Vector2d half = (0.42 * head_px + 1.6 * border_px) * across;
        polyline({from, to - 0.7 * head_px * along}, width_px + 2 * border_px, ink);
        polygon({tip, base + half, base - half}, ink);
    };
    draw(0.5 * width_px, palette::paper);
    draw(0, colour);
}

void Canvas::disc(const Eigen::Vector2d& centre, double radius_px, Colour colour) {
    if (!is_near(centre)) return;
    const int radius = static_cast<int>(std::lround(radius_px * supersampling * (1 << fraction_bits)));
    cv::circle(target_, fixed_point({centre}).front(), radius, bgr(colour), cv::FILLED, cv::LINE_AA,
               fraction_bits);
}

void Canvas::fill(const Box& box, Colour colour, double opacity) {
    cv::Mat part = drawn_pixels(box);
    if (part.empty()) return;
    if (opacity >= 1)
        part.setTo(bgr(colour));
    else
        cv::addWeighted(part, 1 - opacity, cv::Mat(part.size(), CV_8UC3, bgr(colour)), opacity, 0, part);
}

void Canvas::outline(const Box& box, double width_px, Colour colour) {
    polyline({{box.x, box.y},
              {box.right(), box.y},
              {box.right(), box.bottom()},
              {box.x, box.bottom()},
              {box.x, box.y}},
             width_px, colour);
}

void Canvas::text(const std::string& text, double x_px, double baseline_px, double size_px, Colour colour,
                  Weight weight, Align align) {
    texts_.push_back({text, x_px, baseline_px, size_px, colour, weight, align});
}

cv::Mat Canvas::finish() const {
    cv::Mat picture;
    cv::resize(drawn_, picture, {width_px_, height_px_}, 0, 0, cv::INTER_AREA);
    for (const auto& t : texts_)
        draw_text(picture, t.text, t.x_px, t.baseline_px, t.size_px, t.colour, t.weight, t.align);
    return picture;
}

Pixels thinned(const Pixels& path, double spacing_px) {
    Pixels kept;
    Eigen::Vector2d last = Eigen::Vector2d::Constant(NAN);
    for (const auto& p : path) {
        if (!p.allFinite()) continue;
        last = p;
        if (kept.empty() || (p - kept.back()).norm() >= spacing_px) kept.push_back(p);
    }
    if (!kept.empty() && (kept.back() - last).norm() > 0) kept.push_back(last);
    return kept;
}

}  // namespace loopline
