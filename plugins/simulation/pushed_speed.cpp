#include "simulation/pushed_speed.h"

#include <algorithm>
#include <cmath>

#include "simulation/random_waves.h"

namespace loopline::simulation {
namespace {

constexpr double cell_m = 0.02;        ///< of the speed limits along the path
constexpr double stray_m[] = {4, 20};  ///< wavelengths of the speed's variations
constexpr double smoothing_s[] = {0.5, 0.3,
                                  0.2};  ///< of the speed: each makes one more derivative continuous

/// What the path and the person allow, at every cell of the path.
std::vector<double> limits_mps(const CartPath& path, const PushSettings& s, std::size_t cells,
                               double cell_length_m, RandomStream& random) {
    const RandomWaves stray(s.sigma_speed, stray_m[0], stray_m[1], random);
    std::vector<double> limits;
    for (std::size_t i = 0; i <= cells; ++i) {
        const double way_m = static_cast<double>(i) * cell_length_m;
        const double curvature_per_m = std::abs(path.at(way_m).curvature_per_m);
        const double wanted_mps = s.speed_mps * std::max(0.3, 1 + stray.at(way_m));
        limits.push_back(std::min(wanted_mps, s.turn_radps / std::max(curvature_per_m, 1e-6)));
    }
    return limits;
}

/// Cells where the cart stands: the first, the last, and some on the way.
std::vector<std::size_t> stops(const PushSettings& s, std::size_t cells, double cell_length_m,
                               RandomStream& random) {
    std::vector<std::size_t> at{0};
    const double length_m = static_cast<double>(cells) * cell_length_m;
    for (double way_m = 0; s.stop_every_m > 0;) {
        way_m += s.stop_every_m * random.uniform(0.8, 1.2);
        if (way_m > length_m - s.stop_every_m / 2) break;
        at.push_back(static_cast<std::size_t>(way_m / cell_length_m));
    }
    at.push_back(cells);
    return at;
}

/// Lowers speeds until v^2 changes by no more than 2 a per metre.
void limit_acceleration(std::vector<double>& speed_mps, double acceleration_mps2, double cell_length_m) {
    const double change = 2 * acceleration_mps2 * cell_length_m;
    const auto reach = [change](double from_mps) { return std::sqrt(from_mps * from_mps + change); };
    for (std::size_t i = 1; i < speed_mps.size(); ++i)
        speed_mps[i] = std::min(speed_mps[i], reach(speed_mps[i - 1]));
    for (std::size_t i = speed_mps.size() - 1; i > 0; --i)
        speed_mps[i - 1] = std::min(speed_mps[i - 1], reach(speed_mps[i]));
}

/// A cell begins at a time, and is passed at constant acceleration.
struct Timetable {
    std::vector<double> begin_s,
        arrival_s;  ///< of each cell; it begins when the stop at its beginning is over

    double end_s() const { return begin_s.back(); }
};

Timetable timetable(const std::vector<double>& speed_mps, const std::vector<std::size_t>& stop_cells,
                    const PushSettings& s, double cell_length_m) {
    Timetable table;
    double time_s = 0;
    auto stop = stop_cells.begin();
    for (std::size_t i = 0; i < speed_mps.size(); ++i) {
        table.arrival_s.push_back(time_s);
        if (stop != stop_cells.end() && *stop == i) {
            time_s += i == 0 ? s.standstill_s : *stop == speed_mps.size() - 1 ? s.end_standstill_s : s.stop_s;
            ++stop;
        }
        table.begin_s.push_back(time_s);
        if (i + 1 < speed_mps.size()) time_s += 2 * cell_length_m / (speed_mps[i] + speed_mps[i + 1]);
    }
    return table;
}

/// Ways within steps of time.
std::vector<double> sampled_m(const Timetable& table, const std::vector<double>& speed_mps,
                              double cell_length_m, double step_s) {
    std::vector<double> ways_m;
    const auto steps = static_cast<std::size_t>(std::ceil(table.end_s() / step_s));
    std::size_t cell = 0;
    double before_m = 0;
    for (std::size_t k = 1; k <= steps; ++k) {
        const double time_s = static_cast<double>(k) * step_s;
        while (cell + 1 < speed_mps.size() && table.arrival_s[cell + 1] <= time_s) ++cell;
        double way_m = static_cast<double>(cell) * cell_length_m;
        if (cell + 1 < speed_mps.size() && time_s > table.begin_s[cell]) {
            const double inside_s = time_s - table.begin_s[cell];
            const double acceleration_mps2 =
                (std::pow(speed_mps[cell + 1], 2) - std::pow(speed_mps[cell], 2)) / (2 * cell_length_m);
            way_m += std::min(cell_length_m, inside_s * (speed_mps[cell] + acceleration_mps2 * inside_s / 2));
        }
        ways_m.push_back(way_m - before_m);
        before_m = way_m;
    }
    return ways_m;
}

/// The mean over `width` steps, half of them before and half after. What is beyond the ends is 0.
std::vector<double> moving_mean(const std::vector<double>& values, std::size_t width) {
    std::vector<double> means(values.size());
    const std::size_t half = width / 2;
    for (std::size_t i = 0; i < values.size(); ++i) {
        double sum = 0;
        for (std::size_t k = i < half ? 0 : i - half; k <= std::min(i + half, values.size() - 1); ++k)
            sum += values[k];
        means[i] = sum / static_cast<double>(2 * half + 1);
    }
    return means;
}

}  // namespace

std::vector<double> pushed_ways_m(const CartPath& path, const PushSettings& settings, double step_s,
                                  RandomStream random) {
    const auto cells = static_cast<std::size_t>(std::ceil(path.length_m() / cell_m));
    const double cell_length_m = path.length_m() / static_cast<double>(cells);
    auto speed_mps = limits_mps(path, settings, cells, cell_length_m, random);
    const auto stop_cells = stops(settings, cells, cell_length_m, random);
    for (const std::size_t cell : stop_cells) speed_mps[cell] = 0;
    limit_acceleration(speed_mps, settings.speed_mps / settings.speed_up_s, cell_length_m);
    auto ways_m = sampled_m(timetable(speed_mps, stop_cells, settings, cell_length_m), speed_mps,
                            cell_length_m, step_s);
    for (const double width_s : smoothing_s)
        ways_m = moving_mean(ways_m, static_cast<std::size_t>(width_s / step_s));
    return ways_m;
}

}  // namespace loopline::simulation
