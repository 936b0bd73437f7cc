#include "render/correction_view.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "render/content_bounds.h"
#include "render/figure.h"
#include "render/plan.h"
#include "render/scale.h"

namespace loopline {
namespace {

constexpr double wall_away_m = 5;  // where turns are looked at

/// What is drawn of a correction: frames that have a pose before and after.
struct Subject {
    const CorrectionContent& content;
    std::size_t frames = 0;
    std::size_t first_late =
        0;  ///< frames from here on belong to the end of the loop, those before to its beginning
    bool has_loop = false;  ///< both of its frames are there

    const std::vector<Pose2>& poses(bool before) const {
        return before ? content.correction.before : content.correction.after;
    }
    const Pose2& late(bool before) const { return poses(before)[content.correction.loop_to]; }
    const Pose2& old(bool before) const { return poses(before)[content.correction.loop_from]; }
};

bool pose_is_finite(const Pose2& pose) {
    return std::isfinite(pose.x_m) && std::isfinite(pose.y_m) && std::isfinite(pose.phi_rad);
}

Subject subject_of(const CorrectionContent& content) {
    const PathCorrection& correction = content.correction;
    Subject subject{content};
    subject.frames = std::min(correction.before.size(), correction.after.size());
    subject.first_late = (std::size_t{correction.loop_from} + correction.loop_to) / 2 + 1;
    const auto is_there = [&](std::uint32_t frame) {
        return frame < subject.frames && pose_is_finite(correction.before[frame]) &&
               pose_is_finite(correction.after[frame]);
    };
    subject.has_loop = is_there(correction.loop_from) && is_there(correction.loop_to);
    return subject;
}

/// Calls `use(p_map)` with the returns of the frames from `first` up to `end`.
template <class Use>
void for_each_point(const Subject& subject, bool before, std::size_t first, std::size_t end, Use use) {
    const auto& points_base_m = subject.content.frame_points_base_m;
    end = std::min({end, subject.frames, points_base_m.size()});
    for (std::size_t frame = first; frame < end; ++frame) {
        const Pose2& pose = subject.poses(before)[frame];
        if (!pose_is_finite(pose)) continue;
        const auto c = static_cast<float>(std::cos(pose.phi_rad)),
                   s = static_cast<float>(std::sin(pose.phi_rad));
        const auto x_m = static_cast<float>(pose.x_m), y_m = static_cast<float>(pose.y_m);
        for (const Eigen::Vector2f& p : points_base_m[frame])
            use(Eigen::Vector3f(x_m + c * p.x() - s * p.y(), y_m + s * p.x() + c * p.y(), 0));
    }
}

Bounds bounds_of_subject(const Subject& subject) {
    constexpr std::size_t enough_frames = 400;
    const std::size_t stride = subject.frames / enough_frames + 1;
    std::vector<Eigen::Vector3f> sample_m;
    Bounds bounds;
    for (const bool before : {true, false})
        for (std::size_t frame = 0; frame < subject.frames; ++frame) {
            const Pose2& pose = subject.poses(before)[frame];
            bounds.add({pose.x_m, pose.y_m, 0});
            if (frame % stride == 0)
                for_each_point(subject, before, frame, frame + 1,
                               [&](const Eigen::Vector3f& p) { sample_m.push_back(p); });
        }
    bounds.add(bounds_of_points(sample_m));
    return bounds;
}

/// A return near the late scan of the loop, on the nearest wall: nearer than nine in ten.
Eigen::Vector2d near_wall_base_m(const Subject& subject) {
    const std::uint32_t late = subject.content.correction.loop_to;
    std::vector<Eigen::Vector2f> points_m;
    if (late < subject.content.frame_points_base_m.size())
        for (const Eigen::Vector2f& p : subject.content.frame_points_base_m[late])
            if (p.allFinite()) points_m.push_back(p);
    if (points_m.empty()) return {0, 0};
    const auto tenth = points_m.begin() + static_cast<std::ptrdiff_t>(points_m.size() / 10);
    std::nth_element(points_m.begin(), tenth, points_m.end(),
                     [](const auto& a, const auto& b) { return a.squaredNorm() < b.squaredNorm(); });
    return tenth->cast<double>();
}

/// The square with the place of the loop and a wall beside it, where it shows more than the whole map does.
std::optional<Bounds> close_up_of(const Subject& subject, const Bounds& whole) {
    if (!subject.has_loop || whole.empty()) return std::nullopt;
    Bounds bounds;
    for (const bool before : {true, false}) {
        const Eigen::Vector2d wall_m = subject.late(before) * near_wall_base_m(subject);
        bounds.add({subject.late(before).x_m, subject.late(before).y_m, 0});
        bounds.add({wall_m.x(), wall_m.y(), 0});
    }
    const double half_m = std::max(1.0, 0.65 * bounds.extent_m().head<2>().maxCoeff());
    if (half_m > 0.25 * whole.extent_m().head<2>().maxCoeff()) return std::nullopt;
    const Eigen::Vector3d centre_m = bounds.centre_m(), half(half_m, half_m, 0);
    bounds.add(centre_m - half);
    bounds.add(centre_m + half);
    return bounds;
}

void draw_map(Figure& figure, const MapWindow& window, const Subject& subject, bool before, double point_px) {
    for (const bool late : {false, true}) {
        PointDensity density(figure.canvas(), window, false);
        for_each_point(subject, before, late ? subject.first_late : 0,
                       late ? subject.frames : subject.first_late,
                       [&](const Eigen::Vector3f& p) { density.add(p); });
        PointStyle style;
        if (late) style.colour = palette::late_point;
        density.draw(style, point_px);
    }
}

void draw_poses(Figure& figure, const MapWindow& window, const std::vector<Pose2>& poses, Colour colour,
                bool dashed) {
    std::vector<Pose3> path;
    path.reserve(poses.size());
    for (const Pose2& pose : poses) path.emplace_back(pose);
    draw_path(figure.canvas(), window, path, colour, 0.13 * figure.body_px(), dashed);
}

void draw_paths(Figure& figure, const MapWindow& window, const Subject& subject, bool before) {
    if (before) {
        draw_poses(figure, window, subject.content.correction.before, palette::dead_reckoning, true);
        draw_poses(figure, window, subject.content.correction.reverse, palette::reverse, false);
    } else {
        draw_poses(figure, window, subject.content.correction.after, palette::estimate, false);
    }
}

void draw_misclosure(Figure& figure, const MapWindow& window, const Subject& subject, bool is_long) {
    const Pose2 T_map_after = subject.late(true) * subject.content.correction.T_before_after;
    const Eigen::Vector2d from = window.pixel(subject.late(true).translation()),
                          to = window.pixel(T_map_after.translation());
    if (((to - from).norm() > 1.2 * figure.body_px()) == is_long)
        figure.canvas().arrow(from, to, 0.17 * figure.body_px(), palette::ink);
}

void draw_loop(Figure& figure, const MapWindow& window, const Subject& subject, bool before, bool near) {
    const double u = figure.body_px();
    if (before) draw_misclosure(figure, window, subject, true);
    // Both scans may be at one place: a ring around a small square.
    figure.mark(Mark::start, window.pixel(subject.old(before).translation()), 0.55 * u);
    figure.mark(Mark::end, window.pixel(subject.late(before).translation()), 0.34 * u);
    // A short arrow would vanish under the marks; in the whole map it tells nothing that the close-up does
    // not.
    if (before && near) draw_misclosure(figure, window, subject, false);
}

void outline_close_up(Figure& figure, const MapWindow& window, const Bounds& close_up) {
    const Eigen::Vector2d low = window.pixel(close_up.low_m.head<2>()),
                          high = window.pixel(close_up.high_m.head<2>());
    figure.canvas().outline({low.x(), high.y(), high.x() - low.x(), low.y() - high.y()}, 1, palette::ink);
}

Figure::Text text_of(const Subject& subject, bool with_close_up) {
    Figure::Text text;
    text.title = subject.content.title;
    text.subtitle = subject.content.subtitle;
    text.axes = true;
    text.columns = with_close_up ? 2 : 0;
    text.scale_in_titles = true;
    text.panel_titles = {"Before", "After"};
    if (with_close_up)
        text.panel_titles.insert(text.panel_titles.end(), {"Close-up before", "Close-up after"});
    text.legend = {{Mark::dashed_line, "Path before", palette::dead_reckoning},
                   {Mark::line, "Path after", palette::estimate}};
    if (!subject.content.correction.reverse.empty())
        text.legend.push_back({Mark::line, "Path found backwards", palette::reverse});
    if (!subject.has_loop) return text;
    text.legend.push_back({Mark::arrow, "Misclosure", palette::ink});
    text.legend.push_back({Mark::start, "Old scan of the loop", {}});
    text.legend.push_back({Mark::end, "Late scan", {}});
    text.legend.push_back({Mark::points, "Old returns", palette::scan_point});
    text.legend.push_back({Mark::points, "Late returns", palette::late_point});
    return text;
}

}  // namespace

std::string misclosure_text(const Pose2& T_before_after) {
    const double shift_m = T_before_after.translation().norm();
    const double turn_deg = std::abs(T_before_after.phi_rad) * 180 / M_PI;
    return tick_text(shift_m, shift_m < 0.095  ? 0.001
                              : shift_m < 9.95 ? 0.01
                                               : 0.1) +
           " m and " + tick_text(turn_deg, turn_deg < 0.95 ? 0.01 : 0.1) + "\u00b0";
}

double misclosure_size_m(const Pose2& T_before_after) {
    return T_before_after.translation().norm() + wall_away_m * std::abs(T_before_after.phi_rad);
}

cv::Mat draw_correction(const CorrectionContent& content, PictureSize size) {
    const Subject subject = subject_of(content);
    const Bounds whole = bounds_of_subject(subject);
    const auto close_up = close_up_of(subject, whole);
    Figure figure(size, text_of(subject, close_up.has_value()));
    Canvas& canvas = figure.canvas();
    const double u = figure.body_px();
    for (std::size_t panel = 0; panel < (close_up ? 4 : 2); ++panel) {
        const bool before = panel % 2 == 0, near = panel >= 2;
        const MapWindow window = fitting_window(near ? *close_up : whole, figure.panel(panel));
        canvas.clip(window.box);
        figure.graticule(window);
        draw_map(figure, window, subject, before, std::max(1.0, (near ? 0.12 : 0.07) * u));
        draw_paths(figure, window, subject, before);
        if (close_up && !near) outline_close_up(figure, window, *close_up);
        if (subject.has_loop) draw_loop(figure, window, subject, before, near || !close_up);
        canvas.unclip();
        figure.frame(panel);
        figure.tick_labels(window, before || figure.panel(0).y != figure.panel(1).y);
        if (before) figure.scale_bar(window.px_per_m, panel);
        if (whole.empty()) figure.message(panel, "Nothing to draw");
    }
    return figure.finish();
}

PictureSize correction_picture_size(const CorrectionContent& content) {
    const Subject subject = subject_of(content);
    const Bounds whole = bounds_of_subject(subject);
    if (whole.empty()) return {};
    constexpr double panel_px = 600, furniture_px = 190;
    const bool with_close_up = close_up_of(subject, whole).has_value();
    const Eigen::Vector3d extent_m = whole.extent_m().cwiseMax(1.0);
    const double upper_px =
        std::clamp(panel_px * extent_m.y() / extent_m.x(), 380.0, with_close_up ? 600.0 : 900.0);
    return {1280, static_cast<int>((with_close_up ? 2 : 1) * upper_px + furniture_px)};
}

}  // namespace loopline
