/// Layers of the plan, from the ground up.
#include "render/plan.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace loopline {
namespace {

constexpr int S = Canvas::supersampling;

/// Lays `colour` over the pixels, by `alpha` in [0, 1] per pixel.
template <class ColourAt>
void blend(cv::Mat& bgr, const cv::Mat1f& alpha, ColourAt colour_at) {
    for (int y = 0; y < bgr.rows; ++y) {
        auto* pixels = bgr.ptr<cv::Vec3b>(y);
        const float* a = alpha[y];
        for (int x = 0; x < bgr.cols; ++x) {
            if (a[x] < 1.f / 512) continue;
            const Colour ink = colour_at(x, y);
            const float channel[3] = {float(ink.blue), float(ink.green), float(ink.red)};
            for (int c = 0; c < 3; ++c)
                pixels[x][c] =
                    cv::saturate_cast<unsigned char>(pixels[x][c] + a[x] * (channel[c] - pixels[x][c]));
        }
    }
}

/// Darkness per cell: 0 unknown, a little for free, 1 for occupied.
cv::Mat1f darkness_of(const mrpt::maps::COccupancyGridMap2D& grid) {
    using Cell = mrpt::maps::COccupancyGridMap2D::cellType;
    constexpr float free_darkness = 0.16f;
    const auto darkness = [](float p_free) {
        if (std::abs(p_free - 0.5f) <= 0.02f) return 0.f;
        return p_free > 0.5f ? free_darkness : free_darkness + (1 - free_darkness) * (1 - 2 * p_free);
    };
    cv::Mat1f image(static_cast<int>(grid.getSizeY()), static_cast<int>(grid.getSizeX()));
    for (int row = 0; row < image.rows; ++row) {
        const Cell* cells = grid.getRow(row);
        for (int column = 0; column < image.cols; ++column)
            image(row, column) = darkness(mrpt::maps::COccupancyGridMap2D::l2p(cells[column]));
    }
    return image;
}

}  // namespace

void draw_grid(Canvas& canvas, const MapWindow& window, const mrpt::maps::COccupancyGridMap2D& grid) {
    cv::Mat pixels = canvas.drawn_pixels(window.box);
    if (pixels.empty() || grid.getSizeX() == 0 || grid.getSizeY() == 0) return;
    cv::Mat1f darkness = darkness_of(grid);
    double cell_m = grid.getResolution();
    // Many cells a pixel: average them first.
    const double px_per_cell = window.px_per_m * S * cell_m;
    if (px_per_cell < 0.75) {
        const int columns = std::max(1, static_cast<int>(std::lround(darkness.cols * px_per_cell)));
        const int rows = std::max(1, static_cast<int>(std::lround(darkness.rows * px_per_cell)));
        cv::resize(darkness, darkness, {columns, rows}, 0, 0, cv::INTER_AREA);
    }
    const double cell_x_m = (grid.getXMax() - grid.getXMin()) / darkness.cols;
    const double cell_y_m = (grid.getYMax() - grid.getYMin()) / darkness.rows;
    // From pixel to cell, both counted from the centre of number 0; the picture's y is down, the grid's is
    // up.
    const double px_m = 1 / (window.px_per_m * S);
    const double left_m = window.left_m() + px_m / 2 - grid.getXMin(),
                 top_m = window.top_m() - px_m / 2 - grid.getYMin();
    const cv::Matx23d cell_of_pixel(px_m / cell_x_m, 0, left_m / cell_x_m - 0.5, 0, -px_m / cell_y_m,
                                    top_m / cell_y_m - 0.5);
    cv::Mat1f alpha;
    cv::warpAffine(darkness, alpha, cell_of_pixel, pixels.size(), cv::INTER_LINEAR | cv::WARP_INVERSE_MAP,
                   cv::BORDER_CONSTANT, 0);
    blend(pixels, alpha, [](int, int) { return palette::grid_occupied; });
}

PointDensity::PointDensity(Canvas& canvas, const MapWindow& window, bool by_height)
    : pixels_(canvas.drawn_pixels(window.box)),
      count_(cv::Mat1f::zeros(pixels_.size())),
      height_(cv::Mat1f::zeros(by_height ? pixels_.size() : cv::Size(1, 1))),
      left_m_(window.left_m()),
      top_m_(window.top_m()),
      px_per_m_(window.px_per_m * S) {}

void PointDensity::add(const Eigen::Vector3f& p) {
    const double x = (p.x() - left_m_) * px_per_m_, y = (top_m_ - p.y()) * px_per_m_;
    if (!(x >= 0 && y >= 0 && x < count_.cols && y < count_.rows) || !std::isfinite(p.z())) return;
    float& n = count_(static_cast<int>(y), static_cast<int>(x));
    hit_pixels_ += n == 0;
    n += 1;
    hits_ += 1;
    if (height_.rows > 1) height_(static_cast<int>(y), static_cast<int>(x)) += p.z();
}

void PointDensity::draw(const PointStyle& style, double point_px) {
    if (hits_ == 0) return;
    const double sigma = point_px * S / 2;
    cv::GaussianBlur(count_, count_, {0, 0}, sigma);
    if (style.by_height) cv::GaussianBlur(height_, height_, {0, 0}, sigma);
    // A single point is 0.6 opaque where points are sparse, and less where many share a pixel.
    const double single = std::max(0.05, 0.6 * hit_pixels_ / hits_);
    const float per_point = static_cast<float>(-std::log(1 - single) * 2 * M_PI * sigma * sigma);
    // In place where nobody needs the counts any more: these images are what a picture's memory goes into.
    cv::Mat1f alpha = style.by_height ? cv::Mat1f() : count_;
    count_.convertTo(alpha, CV_32F, -per_point);
    cv::exp(alpha, alpha);
    cv::subtract(1, alpha, alpha);
    if (style.by_height) {
        const double span_m = std::max(1e-3, style.highest_m - style.lowest_m);
        blend(pixels_, alpha, [&](int x, int y) {
            return palette::height((height_(y, x) / std::max(count_(y, x), 1e-12f) - style.lowest_m) /
                                   span_m);
        });
    } else {
        blend(pixels_, alpha, [&](int, int) { return style.colour; });
    }
}

void draw_points(Canvas& canvas, const MapWindow& window, const std::vector<Eigen::Vector3f>& points_m,
                 const PointStyle& style, double point_px) {
    if (points_m.empty()) return;
    PointDensity density(canvas, window, style.by_height);
    for (const auto& p : points_m) density.add(p);
    density.draw(style, point_px);
}

void draw_walls(Canvas& canvas, const MapWindow& window, const LineMap& lines, double width_px) {
    for (const auto& line : lines)
        if (line.start_m.allFinite() && line.end_m.allFinite())
            canvas.polyline({window.pixel(line.start_m), window.pixel(line.end_m)}, width_px, palette::wall);
}

void draw_path(Canvas& canvas, const MapWindow& window, const std::vector<Pose3>& path, Colour colour,
               double width_px, bool dashed) {
    Pixels vertices;
    vertices.reserve(path.size());
    for (const auto& pose : path) vertices.push_back(window.pixel(pose.translation_m.head<2>()));
    vertices = thinned(vertices, 0.5);
    canvas.polyline(vertices, 1.9 * width_px, palette::paper);
    if (dashed)
        canvas.dashed_polyline(vertices, width_px, 3.2 * width_px, colour);
    else
        canvas.polyline(vertices, width_px, colour);
}

}  // namespace loopline
