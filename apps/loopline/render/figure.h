/// The furniture of every picture: title, panels, axes, legend and scale bar, laid out for any size.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "render/canvas.h"
#include "render/picture_size.h"

namespace loopline {

enum class Mark { line, dashed_line, wall, points, start, end, dead_reckoning_end, heights, occupied, arrow };

struct LegendEntry {
    Mark mark;
    std::string text;
    Colour colour;
};

/// A part of the map plane in a part of the picture: x right, y up, one scale for both.
struct MapWindow {
    Box box;
    Eigen::Vector2d centre_m = Eigen::Vector2d::Zero();
    double px_per_m = 1;

    Eigen::Vector2d pixel(const Eigen::Vector2d& p_map) const {
        return box.centre() + px_per_m * Eigen::Vector2d(p_map.x() - centre_m.x(), centre_m.y() - p_map.y());
    }
    double left_m() const { return centre_m.x() - box.width / 2 / px_per_m; }
    double right_m() const { return centre_m.x() + box.width / 2 / px_per_m; }
    double bottom_m() const { return centre_m.y() - box.height / 2 / px_per_m; }
    double top_m() const { return centre_m.y() + box.height / 2 / px_per_m; }
};

/// A bar with the colours of heights, beside the panels.
struct ColourBar {
    double lowest_m = 0, highest_m = 1;
};

class Figure {
 public:
    struct Text {
        std::string title;
        std::string subtitle;
        std::vector<LegendEntry> legend;
        std::vector<std::string>
            panel_titles;        ///< one for each panel; a single empty one for an untitled panel
        std::string scale_note;  ///< where the scale bar holds, empty if everywhere
        bool axes = false;       ///< room for tick labels
        std::size_t columns =
            0;  ///< of panels, row by row; 0: all side by side, or one above the other where it is upright
        bool scale_in_titles = false;  ///< a scale bar at the end of panels' titles, where scales differ
        std::optional<ColourBar> colour_bar{};
    };

    Figure(PictureSize size, const Text& text);

    Canvas& canvas() { return canvas_; }
    const Box& panel(std::size_t index) const { return panels_[index]; }
    /// Size of ordinary text; widths of lines and marks go with it.
    double body_px() const { return body_px_; }

    void graticule(const MapWindow& window);
    void frame(std::size_t panel);
    /// Tick labels in metres along the left and lower edge of a panel.
    void tick_labels(const MapWindow& window, bool left_labels);
    /// A bar of round length, at the place kept for it.
    void scale_bar(double px_per_m);
    /// The same at the end of a panel's title.
    void scale_bar(double px_per_m, std::size_t panel);
    /// A sentence in the middle of a panel.
    void message(std::size_t panel, const std::string& sentence);
    /// A mark of the map, also used in the legend: discs and squares for start and end.
    void mark(Mark mark, const Eigen::Vector2d& at, double radius_px);

    cv::Mat finish() const { return canvas_.finish(); }

 private:
    void place_legend(const std::vector<LegendEntry>& entries, double left, double right, double top);
    std::vector<std::vector<std::size_t>> legend_rows(const std::vector<LegendEntry>& entries,
                                                      double width_px) const;
    double entry_width_px(const LegendEntry& entry) const;
    void draw_colour_bar(const ColourBar& bar, double right);
    void swatch(const LegendEntry& entry, const Box& box);
    void draw_scale_bar(double px_per_m, const Box& box);

    Canvas canvas_;
    double body_px_, small_px_, line_px_;
    std::string scale_note_;
    bool has_labels_ = false;  ///< large enough for ticks and scale
    std::vector<Box> panels_;
    std::vector<Box> title_boxes_;
    Box scale_box_;
};

}  // namespace loopline
