/// Curves of the run over time and distance.
#include <algorithm>
#include <cmath>

#include "api/pose2.h"
#include "render/report/html.h"
#include "render/report/sections.h"
#include "render/report/svg_plot.h"

namespace loopline {
namespace {

using Points = std::vector<Eigen::Vector2d>;
constexpr std::size_t most_points = 800;  // of a curve 400 units wide
constexpr double degrees = 180 / M_PI;

std::string figure(const Plot& plot, const std::string& caption) {
    const std::string svg = svg_plot(plot);
    return svg.empty() ? ""
                       : "<figure><h3>" + html::escaped(plot.title) + "</h3>" + svg + "<figcaption>" +
                             caption + "</figcaption></figure>\n";
}

/// Positions at least a thousandth of the path's size apart, the last one included.
Points places_of(const std::vector<StampedPose>& path) {
    Eigen::Vector2d low = Eigen::Vector2d::Constant(INFINITY), high = -low;
    for (const auto& pose : path) {
        low = low.cwiseMin(pose.T_map_base.translation_m.head<2>());
        high = high.cwiseMax(pose.T_map_base.translation_m.head<2>());
    }
    const double spacing_m = path.empty() ? 0 : (high - low).maxCoeff() / 1000;
    Points places;
    for (std::size_t i = 0; i < path.size(); ++i) {
        const Eigen::Vector2d p = path[i].T_map_base.translation_m.head<2>();
        if (places.empty() || i + 1 == path.size() || (p - places.back()).norm() >= spacing_m)
            places.push_back(p);
    }
    return places;
}

std::string trajectory_plot(const RunFiles& run) {
    Plot plot;
    plot.title = "Trajectory";
    plot.x_label = "x, m";
    plot.y_label = "y, m";
    plot.equal_scale = true;
    plot.height = 560;
    const Points estimate = places_of(run.estimate), odometry = places_of(run.odometry);
    plot.series = {{"odometry", odometry, false}, {"estimate", estimate, false}};
    if (!estimate.empty())
        plot.marks = {{"start", {estimate.front()}, false}, {"end", {estimate.back()}, false}};
    std::string keys;
    if (!estimate.empty()) keys += "<span class=\"key estimate\">estimate</span>";
    if (!odometry.empty()) keys += "<span class=\"key odometry\">dead reckoning</span>";
    if (!estimate.empty()) keys += "<span class=\"key start\">start</span><span class=\"key end\">end</span>";
    return figure(plot, keys);
}

/// Bands of one, two and three standard deviations round zero.
std::string sigma_plot(const RunFiles& run, const std::string& title, const std::string& y_label,
                       double Sigma::*member, double scale) {
    Points curve;
    for (const auto& sigma : run.sigmas)
        curve.push_back(
            {seconds_between(run.sigmas.front().stamp_ns, sigma.stamp_ns), scale * (sigma.*member)});
    curve = thinned_signal(curve, most_points / 2);
    Plot plot;
    plot.title = title;
    plot.x_label = "time, s";
    plot.width = 340;
    plot.height = 220;
    plot.y_label = y_label;
    for (const double times : {3.0, 2.0, 1.0}) {
        PlotSeries band{"band", {}, true};
        for (const auto& p : curve) band.points.push_back({p.x(), times * p.y()});
        for (auto p = curve.rbegin(); p != curve.rend(); ++p)
            band.points.push_back({p->x(), -times * p->y()});
        plot.series.push_back(band);
    }
    return figure(plot, "One, two and three standard deviations, from the inside out");
}

struct Differences {
    Points position_m, heading_deg;  ///< over the distance travelled by the estimate, m
};

/// Pairs of poses with the same stamp, in the order of both files.
Differences differences_of(const RunFiles& run) {
    constexpr std::ptrdiff_t farthest_ahead = 1000;
    Differences out;
    double distance_m = 0;
    std::size_t k = 0;
    for (std::size_t i = 0; i < run.estimate.size(); ++i) {
        const Pose3& estimate = run.estimate[i].T_map_base;
        if (i > 0)
            distance_m += (estimate.translation_m - run.estimate[i - 1].T_map_base.translation_m).norm();
        // In some logs stamps go backwards: look ahead for the same stamp, do not compare which is later.
        const auto first = run.odometry.begin() + static_cast<std::ptrdiff_t>(k);
        const auto last = first + std::min<std::ptrdiff_t>(farthest_ahead, run.odometry.end() - first);
        const auto same = std::find_if(
            first, last, [&](const StampedPose& o) { return o.stamp_ns == run.estimate[i].stamp_ns; });
        if (same == last) continue;
        k = same - run.odometry.begin() + 1;
        out.position_m.push_back(
            {distance_m, (estimate.translation_m - same->T_map_base.translation_m).norm()});
        out.heading_deg.push_back(
            {distance_m, degrees * wrap_to_pi(estimate.yaw_rad() - same->T_map_base.yaw_rad())});
    }
    return out;
}

}  // namespace

std::string plots_section(const RunFiles& run) {
    std::string plots = trajectory_plot(run);
    const Differences differences = differences_of(run);
    Plot plot;
    plot.x_label = "distance travelled, m";
    plot.title = "Estimate against dead reckoning: position";
    plot.y_label = "distance apart, m";
    plot.series = {{"estimate", thinned_signal(differences.position_m, most_points), false}};
    plot.height = 250;
    std::string apart = figure(plot, "How far the estimate has moved away from dead reckoning");
    plot.title = "Estimate against dead reckoning: heading";
    plot.y_label = "difference, \u00b0";
    plot.series = {{"estimate", thinned_signal(differences.heading_deg, most_points), false}};
    apart += figure(plot, "Heading of the estimate minus that of dead reckoning");
    // A column of two lower plots beside the tall one.
    if (!apart.empty()) plots += "<div class=\"stack\">" + apart + "</div>\n";
    if (!run.sigmas.empty()) {
        plots += "</section>\n<section class=\"plots three\">\n";
        plots += sigma_plot(run, "Uncertainty of x", "\u00b1 m", &Sigma::x_m, 1);
        plots += sigma_plot(run, "Uncertainty of y", "\u00b1 m", &Sigma::y_m, 1);
        plots += sigma_plot(run, "Uncertainty of heading", "\u00b1 \u00b0", &Sigma::yaw_rad, degrees);
    }
    return plots.empty() ? "" : "<h2>Curves</h2>\n<section class=\"plots\">\n" + plots + "</section>\n";
}

}  // namespace loopline
