#include "fusion/fix_lag.h"

#include <algorithm>
#include <cmath>

#include "api/dense_algebra.h"

namespace loopline::fusion {
namespace {

constexpr double stretch_s = 15, stretch_way_m = 15;
constexpr double pair_s = 2;
constexpr std::size_t fewest_pairs = 8, fewest_stretches = 6;
constexpr double tells_s = 0.15;      // standard deviation of the lag of a stretch that counts
constexpr double farthest_lag_s = 3;  // beside it a search has gone astray
constexpr double least_scatter_m = 0.005;

/// Where a path was, and how fast, between its places.
class PathInTime {
 public:
    explicit PathInTime(const std::vector<PlaceAt>& places) : places_(places) {}
    bool covers(double time_s) const {
        return places_.size() > 1 && time_s >= places_.front().time_s && time_s < places_.back().time_s;
    }
    /// At a time that it covers.
    Eigen::Vector2d at(double time_s) const {
        const auto [a, b] = around(time_s);
        return a.p_m + (time_s - a.time_s) * velocity_mps(time_s);
    }
    Eigen::Vector2d velocity_mps(double time_s) const {
        const auto [a, b] = around(time_s);
        return (b.p_m - a.p_m) / (b.time_s - a.time_s);
    }

 private:
    std::pair<const PlaceAt&, const PlaceAt&> around(double time_s) const {
        const auto after = std::upper_bound(places_.begin() + 1, places_.end() - 1, time_s,
                                            [](double t, const PlaceAt& place) { return t < place.time_s; });
        return {*(after - 1), *after};
    }
    const std::vector<PlaceAt>& places_;
};

double median(std::vector<double> values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

/// What lies between two fixes of a stretch: (a, -b; b, a) (p(to - lag) - p(from - lag)), whatever the
/// heading and the scale of the path are. A signal that is reflected from somewhen on spoils only the pairs
/// around that moment, and an error that changes slowly is in none.
class Stretch {
 public:
    Stretch(const PathInTime& path, const std::vector<PlaceAt>& fixes) : path_(path) {
        std::size_t to = 0;
        for (const PlaceAt& from : fixes) {
            while (to < fixes.size() && fixes[to].time_s < from.time_s + pair_s) ++to;
            if (to == fixes.size()) break;
            pairs_.push_back({from.time_s, fixes[to].time_s, fixes[to].p_m - from.p_m});
        }
    }

    /// The lag and its standard deviation. Gauss-Newton, pairs that are far off weighted down (Cauchy).
    std::optional<std::pair<double, double>> lag() const {
        constexpr int steps = 50;
        constexpr double enough_s = 1e-3, far_m = 1e6;
        if (pairs_.size() < fewest_pairs) return std::nullopt;
        Parameters x = Parameters::Zero();
        double scatter_m = far_m;
        for (int i = 0; i < steps; ++i) {
            if (!covered(x[lag_at])) return std::nullopt;
            Matrix H = Matrix::Zero();
            Parameters g = Parameters::Zero();
            std::vector<double> off_m;
            for (const Pair& pair : pairs_) {
                const Eigen::Matrix<double, 2, parameters> J = jacobian(x, pair);
                const Eigen::Vector2d e = pair.way_m - turned(x, way_m(x, pair));
                const double weight = 1 / (1 + e.squaredNorm() / (scatter_m * scatter_m));
                H += weight * J.transpose() * J;
                g += weight * J.transpose() * e;
                off_m.push_back(e.norm());
            }
            if (i == 0) H(lag_at, lag_at) += far_m * far_m;  // first heading and scale
            const Matrix covariance = inverse_of(H);
            const Parameters step = covariance * g;
            if (!step.allFinite()) return std::nullopt;
            x += step;
            if (std::abs(x[lag_at]) > farthest_lag_s) return std::nullopt;
            if (i > 0) scatter_m = std::max(2 * median(off_m), least_scatter_m);
            if (i > 3 && std::abs(step[lag_at]) < enough_s)
                return std::pair{x[lag_at], scatter_m / 2 * std::sqrt(covariance(lag_at, lag_at))};
        }
        return std::nullopt;
    }

 private:
    static constexpr int parameters = 3, lag_at = 2;  // a, b, lag
    using Parameters = Eigen::Matrix<double, parameters, 1>;
    using Matrix = Eigen::Matrix<double, parameters, parameters>;
    struct Pair {
        double from_s, to_s;
        Eigen::Vector2d way_m;
    };

    bool covered(double lag_s) const {
        return path_.covers(pairs_.front().from_s - lag_s) && path_.covers(pairs_.back().to_s - lag_s);
    }
    Eigen::Vector2d way_m(const Parameters& x, const Pair& pair) const {
        return path_.at(pair.to_s - x[lag_at]) - path_.at(pair.from_s - x[lag_at]);
    }
    static Eigen::Vector2d turned(const Parameters& x, const Eigen::Vector2d& v) {
        return {x[0] * v.x() - x[1] * v.y(), x[1] * v.x() + x[0] * v.y()};
    }
    Eigen::Matrix<double, 2, parameters> jacobian(const Parameters& x, const Pair& pair) const {
        const Eigen::Vector2d p = way_m(x, pair),
                              v = turned(x, path_.velocity_mps(pair.to_s - x[lag_at]) -
                                                path_.velocity_mps(pair.from_s - x[lag_at]));
        Eigen::Matrix<double, 2, parameters> J;
        J << p.x(), -p.y(), -v.x(),  //
            p.y(), p.x(), -v.y();
        return J;
    }

    const PathInTime& path_;
    std::vector<Pair> pairs_;
};

}  // namespace

std::optional<FixLag> lag_of_fixes(const std::vector<PlaceAt>& path, const std::vector<PlaceAt>& fixes) {
    const PathInTime in_time(path);
    std::vector<double> lags_s;
    for (std::size_t first = 0; first < fixes.size();) {
        std::vector<PlaceAt> within;
        std::size_t next = first;
        for (; next < fixes.size() && fixes[next].time_s < fixes[first].time_s + stretch_s; ++next)
            if (in_time.covers(fixes[next].time_s)) within.push_back(fixes[next]);
        first = next;
        if (within.empty() || (within.back().p_m - within.front().p_m).norm() < stretch_way_m) continue;
        const auto lag = Stretch(in_time, within).lag();
        if (lag && lag->second < tells_s) lags_s.push_back(lag->first);
    }
    if (lags_s.size() < fewest_stretches) return std::nullopt;
    FixLag found;
    found.stretches = lags_s.size();
    found.lag_s = median(lags_s);
    for (double& lag_s : lags_s) lag_s = std::abs(lag_s - found.lag_s);
    // Of the median of what is normally distributed.
    found.sigma_s = 1.2533 * 1.4826 * median(lags_s) / std::sqrt(static_cast<double>(found.stretches));
    return found;
}

}  // namespace loopline::fusion
