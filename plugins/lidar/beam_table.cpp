#include "lidar/beam_table.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "api/parameters.h"

namespace loopline::lidar {
namespace {

const char* const key = "elevations_deg";

/// Four decimals, which is more than a manual has.
double rounded(double angle_deg) {
    return std::round(angle_deg * 1e4) / 1e4;
}

std::vector<double> evenly(double first_deg, double step_deg, int count) {
    std::vector<double> angles_deg;
    for (int i = 0; i < count; ++i) angles_deg.push_back(rounded(first_deg + i * step_deg));
    return angles_deg;
}

/// Velodyne's numbers: even ones from the lowest beam up, odd ones from the middle up.
std::vector<double> alternating(double lowest_deg, double step_deg, int count) {
    std::vector<double> angles_deg;
    for (int i = 0; i < count; ++i)
        angles_deg.push_back(rounded(lowest_deg + (i / 2 + (i % 2) * count / 2) * step_deg));
    return angles_deg;
}

}  // namespace

std::optional<BeamTable> table_of_beams(int beams) {
    if (beams == 16) return BeamTable{"VLP-16", evenly(15, -2, 16)};
    if (beams == 32) return BeamTable{"HDL-32E", evenly(32.0 / 3, -4.0 / 3, 32)};
    if (beams != 64) return std::nullopt;
    BeamTable table{"HDL-64E", evenly(2, -1.0 / 3, 32)};
    const auto lower = evenly(-53.0 / 6, -0.5, 32);
    table.elevations_deg.insert(table.elevations_deg.end(), lower.begin(), lower.end());
    return table;
}

std::string text_of(const BeamTable& table) {
    std::string text = table.model + " " + key;
    for (const double angle_deg : table.elevations_deg) text += " " + number_text(angle_deg);
    return text;
}

std::optional<BeamTable> table_from_text(const std::string& lidar_model) {
    const auto words = split_words(lidar_model, " ");
    const auto found = std::find(words.begin(), words.end(), key);
    if (found == words.end()) {
        if (lidar_model.rfind("VLP-16", 0) == 0) return BeamTable{"VLP-16", alternating(-15, 2, 16)};
        if (lidar_model.rfind("HDL-32", 0) == 0)
            return BeamTable{"HDL-32E", alternating(-92.0 / 3, 4.0 / 3, 32)};
        return std::nullopt;
    }
    BeamTable table{words.front(), {}};
    for (auto word = found + 1; word != words.end(); ++word) {
        const auto angle_deg = number_from_text(*word);
        if (!angle_deg) return std::nullopt;
        table.elevations_deg.push_back(*angle_deg);
    }
    return table;
}

std::vector<int> from_high_to_low(const std::vector<double>& elevations) {
    std::vector<int> order(elevations.size());
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
        return elevations[static_cast<std::size_t>(a)] > elevations[static_cast<std::size_t>(b)];
    });
    return order;
}

}  // namespace loopline::lidar
