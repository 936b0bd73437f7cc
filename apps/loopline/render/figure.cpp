/// From top to bottom: title and subtitle, the panels, a strip with the scale bar at its left and the legend
/// beside it.
#include "render/figure.h"

#include <algorithm>
#include <cmath>

#include "render/scale.h"

namespace loopline {
namespace {

constexpr double colour_bar_ems = 4.6;  // what a colour bar takes of the width
constexpr double swatch_ems = 2.3;  // a legend's swatch with the space after it

/// Text grows more slowly than the picture: 9 px at 320x240, 16 px at 1280x960.
double body_size_px(PictureSize size) {
    const double side_px = std::sqrt(static_cast<double>(size.width_px) * size.height_px);
    const double by_area = 6.7 + 0.0084 * side_px, by_edge = std::min(size.width_px, size.height_px) / 12.0;
    return std::max(6.0, std::min(by_area, by_edge));
}

}  // namespace

Figure::Figure(PictureSize size, const Text& text)
    : canvas_(size.width_px, size.height_px, palette::paper),
      body_px_(body_size_px(size)),
      small_px_(std::max(8.0, 0.82 * body_px_)),
      line_px_(1.55 * body_px_),
      scale_note_(text.scale_note) {
    const double margin = 0.9 * body_px_, width = size.width_px, height = size.height_px;
    const double inner = width - 2 * margin;
    double top = margin;
    // Furniture goes, the least needed first, where it would leave the map less than half of the height.
    const bool tiny = height < 12 * body_px_ || width < 14 * body_px_;
    if (!text.title.empty() && !tiny) {
        const double title_px = 1.4 * body_px_;
        canvas_.text(fitting_text(text.title, inner, title_px, Weight::bold), margin, top + 0.85 * title_px,
                     title_px, palette::ink, Weight::bold);
        top += 1.3 * title_px;
        if (!text.subtitle.empty()) {
            canvas_.text(fitting_text(text.subtitle, inner, body_px_), margin, top + 0.8 * body_px_, body_px_,
                         palette::quiet_ink);
            top += 1.35 * body_px_;
        }
        top += 0.3 * body_px_;
    }
    double bottom = height - margin;
    if (!tiny) {
        const double bar_width = std::clamp(0.13 * width, 4 * body_px_, 10 * body_px_);
        const double scale_width = bar_width + text_width_px(" 500 km" + scale_note_, body_px_);
        // The legend stands beside the scale bar, or below it where that takes fewer rows.
        double legend_left = margin + (text.scale_in_titles ? 0 : scale_width + 1.5 * body_px_);
        std::size_t rows =
            std::max<std::size_t>(1, legend_rows(text.legend, width - margin - legend_left).size());
        const bool below = 1 + legend_rows(text.legend, inner).size() < rows;
        if (below) {
            legend_left = margin;
            rows = 1 + legend_rows(text.legend, inner).size();
        }
        const double strip = line_px_ * static_cast<double>(rows);
        if (strip < 0.4 * height) {
            bottom -= strip;
            has_labels_ = true;
            scale_box_ = {margin, bottom, bar_width, line_px_};
            place_legend(text.legend, legend_left, width - margin, bottom + (below ? line_px_ : 0));
            bottom -= 0.5 * body_px_;
        }
    }
    const bool axes = text.axes && !tiny;
    const double label_left = axes ? 3.0 * small_px_ : 0, label_below = axes ? 1.5 * small_px_ : 0;
    const bool with_bar = text.colour_bar && !tiny;
    const double for_panels = inner - (with_bar ? colour_bar_ems * body_px_ : 0);
    const std::size_t count = std::max<std::size_t>(1, text.panel_titles.size());
    const bool stacked = count > 1 && height > 1.15 * width;
    const std::size_t columns = text.columns > 0 ? std::min(text.columns, count) : stacked ? 1 : count;
    const std::size_t rows = (count + columns - 1) / columns;
    const double gap = count > 1 ? 1.2 * body_px_ : 0;
    for (std::size_t i = 0; i < count; ++i) {
        Box cell;
        cell.width = (for_panels - label_left - gap * (columns - 1)) / columns;
        cell.height = (bottom - top - gap * (rows - 1)) / rows;
        cell.x = margin + label_left + (i % columns) * (cell.width + gap);
        cell.y = top + (i / columns) * (cell.height + gap);
        const std::string title =
            i < text.panel_titles.size() && !tiny ? text.panel_titles[i] : std::string();
        title_boxes_.push_back({cell.x, cell.y, cell.width, title.empty() ? 0 : 1.2 * body_px_});
        if (!title.empty()) {
            const double for_scale =
                text.scale_in_titles ? std::min(0.3 * cell.width, 8 * body_px_) + 5 * body_px_ : 0;
            canvas_.text(fitting_text(title, cell.width - for_scale, body_px_, Weight::bold), cell.x,
                         cell.y + 0.9 * body_px_, body_px_, palette::ink, Weight::bold);
            cell.y += 1.5 * body_px_;
            cell.height -= 1.5 * body_px_;
        }
        cell.height -= label_below;
        // Whole pixels, so that frames are crisp and a rendered image fits exactly.
        const double left = std::round(cell.x), upper = std::round(cell.y);
        panels_.push_back({left, upper, std::max(1.0, std::floor(cell.right()) - left),
                           std::max(1.0, std::floor(cell.bottom()) - upper)});
    }
    if (with_bar) draw_colour_bar(*text.colour_bar, width - margin);
}

void Figure::draw_colour_bar(const ColourBar& bar, double right) {
    const double upper = panels_.front().y, lower = panels_.back().bottom();
    const double height_px = std::min(lower - upper, 24 * body_px_);
    const Box box{right - (colour_bar_ems - 1.2) * body_px_, std::round((upper + lower - height_px) / 2),
                  0.9 * body_px_, height_px};
    cv::Mat part = canvas_.drawn_pixels(box);
    for (int y = 0; y < part.rows; ++y) {
        const Colour colour = palette::height(1 - (y + 0.5) / part.rows);
        part.row(y).setTo(cv::Scalar(colour.blue, colour.green, colour.red));
    }
    canvas_.outline(box, 0.5, palette::frame);
    canvas_.text("Height", box.x, box.y - 0.6 * small_px_, small_px_, palette::quiet_ink);
    double step = 0;
    const auto values = ticks(bar.lowest_m, bar.highest_m, std::max(2, int(height_px / (2.2 * body_px_))), step);
    for (const double value : values) {
        const double share = (value - bar.lowest_m) / std::max(1e-9, bar.highest_m - bar.lowest_m);
        const double y = box.bottom() - share * box.height;
        canvas_.polyline({{box.right(), y}, {box.right() + 0.25 * body_px_, y}}, 0.06 * body_px_, palette::ink);
        canvas_.text(tick_text(value, step) + (value == values.back() ? " m" : ""), box.right() + 0.4 * body_px_,
                     y + 0.36 * small_px_, small_px_, palette::quiet_ink);
    }
}

double Figure::entry_width_px(const LegendEntry& entry) const {
    return swatch_ems * body_px_ + text_width_px(entry.text, body_px_) + 1.1 * body_px_;
}

std::vector<std::vector<std::size_t>> Figure::legend_rows(const std::vector<LegendEntry>& entries,
                                                          double width_px) const {
    std::vector<std::vector<std::size_t>> rows;
    double used_px = 0;
    for (std::size_t i = 0; i < entries.size(); ++i) {
        const double wanted_px = entry_width_px(entries[i]);
        if (rows.empty() || used_px + wanted_px > width_px) {
            rows.emplace_back();
            used_px = 0;
        }
        rows.back().push_back(i);
        used_px += wanted_px;
    }
    return rows;
}

void Figure::place_legend(const std::vector<LegendEntry>& entries, double left, double right, double top) {
    double row_top = top;
    for (const auto& row : legend_rows(entries, right - left)) {
        double x = left;
        for (const std::size_t i : row) {
            const auto& entry = entries[i];
            swatch(entry, {x, row_top, (swatch_ems - 0.45) * body_px_, line_px_});
            const double text_left = x + swatch_ems * body_px_;
            canvas_.text(fitting_text(entry.text, right - text_left, body_px_), text_left,
                         row_top + 0.5 * line_px_ + 0.36 * body_px_, body_px_, palette::ink);
            x += entry_width_px(entry);
        }
        row_top += line_px_;
    }
}

void Figure::swatch(const LegendEntry& entry, const Box& box) {
    const Eigen::Vector2d c = box.centre();
    const Pixels bar{{box.x, c.y()}, {box.right(), c.y()}};
    switch (entry.mark) {
        case Mark::line:
            canvas_.polyline(bar, 0.19 * body_px_, entry.colour);
            break;
        case Mark::dashed_line:
            canvas_.dashed_polyline(bar, 0.16 * body_px_, 0.45 * body_px_, entry.colour);
            break;
        case Mark::wall:
            canvas_.polyline(bar, 0.26 * body_px_, entry.colour);
            break;
        case Mark::points:
            for (const auto& [x, y] :
                 {std::pair{0.1, 0.1}, {0.3, -0.12}, {0.52, 0.08}, {0.7, -0.05}, {0.9, 0.12}})
                canvas_.disc({box.x + x * box.width, c.y() + y * box.height}, 0.11 * body_px_, entry.colour);
            break;
        case Mark::heights: {
            cv::Mat part = canvas_.drawn_pixels({box.x, c.y() - 0.3 * body_px_, box.width, 0.6 * body_px_});
            for (int x = 0; x < part.cols; ++x) {
                const Colour colour = palette::height(static_cast<double>(x) / part.cols);
                part.col(x).setTo(cv::Scalar(colour.blue, colour.green, colour.red));
            }
            break;
        }
        case Mark::occupied:
            canvas_.fill({c.x() - 0.8 * body_px_, c.y() - 0.4 * body_px_, 0.8 * body_px_, 0.8 * body_px_},
                         palette::grid_free);
            canvas_.fill({c.x(), c.y() - 0.4 * body_px_, 0.8 * body_px_, 0.8 * body_px_},
                         palette::grid_occupied);
            canvas_.outline({c.x() - 0.8 * body_px_, c.y() - 0.4 * body_px_, 1.6 * body_px_, 0.8 * body_px_},
                            0.5, palette::frame);
            break;
        case Mark::arrow:
            canvas_.arrow(bar.front(), bar.back(), 0.16 * body_px_, entry.colour);
            break;
        default:
            mark(entry.mark, c, 0.42 * body_px_);
    }
}

void Figure::mark(Mark mark, const Eigen::Vector2d& at, double radius_px) {
    const auto square = [&](double half, Colour colour) {
        canvas_.polygon({at + Eigen::Vector2d(-half, -half), at + Eigen::Vector2d(half, -half),
                         at + Eigen::Vector2d(half, half), at + Eigen::Vector2d(-half, half)},
                        colour);
    };
    const double halo_px = 0.28 * radius_px;
    if (mark == Mark::start) {
        canvas_.disc(at, radius_px + halo_px, palette::paper);
        canvas_.disc(at, radius_px, palette::start);
        canvas_.disc(at, 0.42 * radius_px, palette::paper);
    } else {
        const double half = 0.88 * radius_px;
        square(half + halo_px, palette::paper);
        square(half, mark == Mark::end ? palette::end : palette::dead_reckoning);
    }
}

void Figure::frame(std::size_t panel) {
    canvas_.outline(panels_[panel], 0.5, palette::frame);
}

namespace {
int most_ticks(double length_px, double size_px) {
    return std::max(2, static_cast<int>(length_px / (6.5 * size_px)));
}
}  // namespace

void Figure::graticule(const MapWindow& window) {
    double step = 1;
    const int most = most_ticks(std::max(window.box.width, window.box.height), small_px_);
    const double span_m = std::max(window.box.width, window.box.height) / window.px_per_m;
    ticks(0, span_m, most, step);
    for (double x = std::ceil(window.left_m() / step) * step; x <= window.right_m(); x += step) {
        const double px = window.pixel({x, 0}).x();
        canvas_.polyline({{px, window.box.y}, {px, window.box.bottom()}}, 0.5, palette::graticule);
    }
    for (double y = std::ceil(window.bottom_m() / step) * step; y <= window.top_m(); y += step) {
        const double px = window.pixel({0, y}).y();
        canvas_.polyline({{window.box.x, px}, {window.box.right(), px}}, 0.5, palette::graticule);
    }
}

void Figure::tick_labels(const MapWindow& window, bool left_labels) {
    if (!has_labels_) return;
    double step = 1;
    const int most = most_ticks(std::max(window.box.width, window.box.height), small_px_);
    ticks(0, std::max(window.box.width, window.box.height) / window.px_per_m, most, step);
    bool is_first = true;
    for (double x = std::ceil(window.left_m() / step) * step; x <= window.right_m(); x += step) {
        const double px = window.pixel({x, 0}).x();
        const std::string text = tick_text(x, step) + (is_first ? " m" : "");
        const double half = text_width_px(text, small_px_) / 2;
        if (px - half < window.box.x - body_px_ || px + half > window.box.right() + body_px_) continue;
        canvas_.text(text, px, window.box.bottom() + 1.25 * small_px_, small_px_, palette::quiet_ink,
                     Weight::regular, Align::centre);
        is_first = false;
    }
    if (!left_labels) return;
    for (double y = std::ceil(window.bottom_m() / step) * step; y <= window.top_m(); y += step) {
        const double px = window.pixel({0, y}).y();
        if (px < window.box.y + 0.5 * small_px_ || px > window.box.bottom() - 0.3 * small_px_) continue;
        canvas_.text(tick_text(y, step), window.box.x - 0.4 * small_px_, px + 0.36 * small_px_, small_px_,
                     palette::quiet_ink, Weight::regular, Align::right);
    }
}

void Figure::scale_bar(double px_per_m) {
    draw_scale_bar(px_per_m, scale_box_);
}

void Figure::scale_bar(double px_per_m, std::size_t panel) {
    const Box& title = title_boxes_[panel];
    // An even height at a whole pixel keeps the bar crisp.
    Box box{0, std::round(title.y), std::min(0.3 * title.width, 8 * body_px_),
            2 * std::round(title.height / 2)};
    if (!has_labels_ || title.height == 0 || !(px_per_m > 0)) return;
    const double length_m = round_number_below(box.width / px_per_m);
    box.x = title.right() - length_m * px_per_m - 0.45 * body_px_ -
            text_width_px(length_text(length_m), body_px_);
    draw_scale_bar(px_per_m, box);
}

void Figure::draw_scale_bar(double px_per_m, const Box& box) {
    if (box.width == 0 || !(px_per_m > 0)) return;
    const double length_m = round_number_below(box.width / px_per_m);
    const double length_px = length_m * px_per_m, y = box.centre().y(), x = box.x;
    const double end_px = 0.28 * body_px_, thick_px = std::max(1.0, 0.12 * body_px_);
    canvas_.fill({x, y - thick_px / 2, length_px, thick_px}, palette::ink);
    canvas_.fill({x, y - end_px, thick_px, 2 * end_px}, palette::ink);
    canvas_.fill({x + length_px - thick_px, y - end_px, thick_px, 2 * end_px}, palette::ink);
    const double text_left = x + length_px + 0.45 * body_px_;
    canvas_.text(length_text(length_m) + scale_note_, text_left, y + 0.36 * body_px_, body_px_, palette::ink);
}

void Figure::message(std::size_t panel, const std::string& sentence) {
    const Box& box = panels_[panel];
    canvas_.text(fitting_text(sentence, box.width, body_px_), box.centre().x(), box.centre().y(), body_px_,
                 palette::quiet_ink, Weight::regular, Align::centre);
}

}  // namespace loopline
