#include "grid_map/frame.h"

#include <algorithm>
#include <cmath>

namespace loopline::grid_map {
namespace {

/// Sums over the points of a chain up to each of them, so that any part of it is fitted by two differences.
struct Sums {
    double n = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0;
    void add(const Eigen::Vector2d& p) {
        n += 1;
        x += p.x();
        y += p.y();
        xx += p.x() * p.x();
        xy += p.x() * p.y();
        yy += p.y() * p.y();
    }
    Sums operator-(const Sums& o) const {
        return {n - o.n, x - o.x, y - o.y, xx - o.xx, xy - o.xy, yy - o.yy};
    }
};

struct FittedSurface {
    Eigen::Vector2d mean_m = Eigen::Vector2d::Zero(),
                    normal = Eigen::Vector2d::Zero();  ///< towards the origin; zero if there is none
    double variance_m2 = 0;                            ///< of the points about it
    bool exists() const { return !normal.isZero(); }
};

/// The line of least squares through the points; none if they scatter too much about it, or are too close
/// together to tell.
FittedSurface surface_through(const Sums& s, double sigma_max_m) {
    FittedSurface surface;
    const double mx = s.x / s.n, my = s.y / s.n;
    const double cxx = s.xx / s.n - mx * mx, cxy = s.xy / s.n - mx * my, cyy = s.yy / s.n - my * my;
    const double mean = (cxx + cyy) / 2, spread = std::hypot((cxx - cyy) / 2, cxy);
    const double across = std::max(0.0, mean - spread), along = mean + spread;
    surface.mean_m = {mx, my};
    surface.variance_m2 = across * s.n / std::max(1.0, s.n - 2);
    if (across > sigma_max_m * sigma_max_m || across > 0.2 * along || along <= 0) return surface;
    const double direction_rad = 0.5 * std::atan2(2 * cxy, cxx - cyy);
    surface.normal = {-std::sin(direction_rad), std::cos(direction_rad)};
    if (surface.normal.dot(surface.mean_m) > 0) surface.normal = -surface.normal;
    return surface;
}

/// Whether two returns next to each other can be of one surface: as far apart as a surface at 15 degrees to
/// the beams would set them, or closer.
bool joined(const Eigen::Vector2d& a, const Eigen::Vector2d& b, double angle_rad) {
    const double nearer_m = std::min(a.norm(), b.norm());
    const double most_m = 0.1 + 4 * nearer_m * angle_rad;
    return (a - b).squaredNorm() < most_m * most_m;
}

/// The returns of a scan, cut into chains that can be of one surface each.
class Returns {
 public:
    void take(const PlanarScan& scan, const SweepMotion& motion, const FrameSettings& settings) {
        half2_m2_ = settings.surface_half_m * settings.surface_half_m;
        sigma_max_m_ = settings.sigma_surface_m;
        take_points(scan, motion, settings);
        chain(scan.angle_step_rad);
        find_typical_variance();
    }
    std::size_t size() const { return points_.size(); }
    /// Sensor's frame at the first beam.
    const Eigen::Vector2d& point_m(std::size_t i) const { return points_[i]; }
    bool begins_chain(std::size_t i) const { return chain_begin_[i] == i; }

    /// The surface that a return is of. Near a corner, what is to one side of it is a surface, where both
    /// sides together would cut the corner off: by another amount from each distance, which takes scans for
    /// turned that are not.
    FittedSurface surface_at(std::size_t i) const {
        constexpr double suspicious = 4, better = 0.5;  // ratios of variances
        const Part around = around_return(i);
        FittedSurface surface = through(around);
        if (surface.exists() && surface.variance_m2 < suspicious * typical_m2_) return surface;
        double least_m2 = surface.exists() ? better * surface.variance_m2 : suspicious * typical_m2_;
        const std::size_t before = std::min(around.from, i >= 2 ? i - 2 : 0),
                          behind = std::max(around.to, i + 3);
        for (const Part& side : {Part{before, i + 1}, Part{i, behind}}) {
            if (side.from < chain_begin_[i] || side.to > chain_end_[i]) continue;
            const FittedSurface beside = through(side);
            if (!beside.exists() || beside.variance_m2 >= least_m2) continue;
            least_m2 = beside.variance_m2;
            surface = beside;
        }
        return surface;
    }

 private:
    struct Part {
        std::size_t from, to;  ///< without `to`
    };

    void take_points(const PlanarScan& scan, const SweepMotion& motion, const FrameSettings& settings) {
        const double c = std::cos(scan.T_base_sensor.phi_rad), s = std::sin(scan.T_base_sensor.phi_rad);
        // In the sensor's frame at the first beam: what the vehicle moves, and what its turn moves the
        // sensor.
        const Eigen::Vector2d drift_base_m(motion.forward_m - motion.turn_rad * scan.T_base_sensor.y_m,
                                           motion.left_m + motion.turn_rad * scan.T_base_sensor.x_m);
        const Eigen::Vector2d drift_m(c * drift_base_m.x() + s * drift_base_m.y(),
                                      -s * drift_base_m.x() + c * drift_base_m.y());
        const bool moves = drift_m.squaredNorm() > 0 || motion.turn_rad != 0;
        const double per_beam = scan.size() > 1 ? 1 / static_cast<double>(scan.size() - 1) : 0;
        points_.clear();
        beams_.clear();
        for (std::size_t beam = 0; beam < scan.size(); ++beam) {
            if (!scan.has_return(beam)) continue;
            const double range_m = scan.ranges_m[beam];
            if (range_m < settings.min_range_m || range_m > settings.max_range_m) continue;
            points_.push_back(scan.point_sensor_m(beam));
            if (moves) {
                // A sweep is short: its arc is its chord.
                const double part = static_cast<double>(beam) * per_beam, turn = motion.turn_rad * part;
                const Eigen::Vector2d p = points_.back();
                points_.back() = Eigen::Vector2d(p.x() - turn * p.y() - 0.5 * turn * turn * p.x(),
                                                 p.y() + turn * p.x() - 0.5 * turn * turn * p.y()) +
                                 drift_m * part;
            }
            beams_.push_back(beam);
        }
    }

    void chain(double angle_step_rad) {
        const std::size_t n = points_.size();
        sums_.assign(n + 1, {});
        chain_begin_.assign(n, 0);
        chain_end_.assign(n, 0);
        for (std::size_t i = 0; i < n; ++i) {
            sums_[i + 1] = sums_[i];
            sums_[i + 1].add(points_[i]);
            const bool joins = i > 0 && beams_[i] - beams_[i - 1] <= 2 &&
                               joined(points_[i - 1], points_[i],
                                      static_cast<double>(beams_[i] - beams_[i - 1]) * angle_step_rad);
            chain_begin_[i] = joins ? chain_begin_[i - 1] : i;
        }
        for (std::size_t i = n; i-- > 0;)
            chain_end_[i] = i + 1 < n && chain_begin_[i + 1] == chain_begin_[i] ? chain_end_[i + 1] : i + 1;
    }

    /// Of returns about their surface: the median over the scan, which corners don't move.
    void find_typical_variance() {
        constexpr double exact_m2 = 0.001 * 0.001;
        variances_m2_.clear();
        for (std::size_t i = 0; i < size(); ++i)
            if (const FittedSurface surface = through(around_return(i)); surface.exists())
                variances_m2_.push_back(surface.variance_m2);
        typical_m2_ = exact_m2;
        if (variances_m2_.empty()) return;
        const auto middle = variances_m2_.begin() + static_cast<std::ptrdiff_t>(variances_m2_.size() / 2);
        std::nth_element(variances_m2_.begin(), middle, variances_m2_.end());
        typical_m2_ = std::max(typical_m2_, *middle);
    }

    /// At least one neighbour to each side if there is one, more as long as they are close.
    Part around_return(std::size_t i) const {
        const auto close = [&](std::size_t other) {
            return (points_[other] - points_[i]).squaredNorm() < half2_m2_;
        };
        Part part{i, i + 1};
        while (part.from > chain_begin_[i] && (i - part.from < 1 || close(part.from - 1))) --part.from;
        while (part.to < chain_end_[i] && (part.to - i < 2 || close(part.to))) ++part.to;
        return part;
    }

    FittedSurface through(const Part& part) const {
        if (part.to - part.from < 3) return {};
        return surface_through(sums_[part.to] - sums_[part.from], sigma_max_m_);
    }

    double half2_m2_ = 0, sigma_max_m_ = 0, typical_m2_ = 0;
    std::vector<Eigen::Vector2d> points_;
    std::vector<std::size_t> beams_, chain_begin_, chain_end_;
    std::vector<Sums> sums_;  ///< up to and without each point
    std::vector<double> variances_m2_;
};

}  // namespace

double mean_range_m(const Frame& frame) {
    double sum_m = 0;
    for (const SurfacePoint& point : frame.points)
        sum_m += static_cast<double>((point.p_base_m - frame.p_base_sensor_m).norm());
    return frame.points.empty() ? 1 : sum_m / static_cast<double>(frame.points.size());
}

void make_frame(const PlanarScan& scan, const SweepMotion& motion, const FrameSettings& settings,
                Frame& frame) {
    thread_local Returns returns;
    returns.take(scan, motion, settings);
    const double c = std::cos(scan.T_base_sensor.phi_rad), s = std::sin(scan.T_base_sensor.phi_rad);
    frame.p_base_sensor_m = scan.T_base_sensor.translation().cast<float>();
    frame.points.clear();
    frame.points.reserve(returns.size());
    const double spacing2_m2 = settings.spacing_m * settings.spacing_m;
    Eigen::Vector2d kept = Eigen::Vector2d::Zero(), placed = kept;
    for (std::size_t i = 0; i < returns.size(); ++i) {
        const Eigen::Vector2d& point = returns.point_m(i);
        if (!returns.begins_chain(i) && (point - kept).squaredNorm() < spacing2_m2) continue;
        const FittedSurface surface = returns.surface_at(i);
        // The middle of what was fitted, which at the end of a wall lies to one side of the return: there
        // place and direction of the line err together, and that would draw a scan back along its turn.
        const Eigen::Vector2d &normal = surface.normal, &p = surface.exists() ? surface.mean_m : point;
        if (!returns.begins_chain(i) && (p - placed).squaredNorm() < 0.25 * spacing2_m2) continue;
        kept = point;
        placed = p;
        frame.points.push_back(
            {Eigen::Vector2f(static_cast<float>(scan.T_base_sensor.x_m + c * p.x() - s * p.y()),
                             static_cast<float>(scan.T_base_sensor.y_m + s * p.x() + c * p.y())),
             Eigen::Vector2f(static_cast<float>(c * normal.x() - s * normal.y()),
                             static_cast<float>(s * normal.x() + c * normal.y()))});
    }
}

}  // namespace loopline::grid_map
