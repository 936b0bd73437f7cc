#include "cloud_map/range_view.h"

#include <algorithm>
#include <cmath>

#include "cloud_map/azimuth.h"

namespace loopline::cloud_map {
namespace {

constexpr int bins = 1024;
constexpr int fewest_columns = 180, most_columns = 4096;
constexpr int fewest_returns = 4;  ///< of the six beams or more about a place

/// Part `turns` of a turn as a place among `count`.
int part_of_turn(float turns, int count) {
    const int k = static_cast<int>(turns * static_cast<float>(count));
    return k < 0 ? 0 : k >= count ? count - 1 : k;
}

}  // namespace

RangeView::RangeView(const lidar::SpinningScan& scan, const SweepMotion& motion)
    : origin_m_(motion.middle_m()) {
    std::vector<float> turns(scan.points.size());
    for (std::size_t i = 0; i < turns.size(); ++i)
        turns[i] = azimuth_turns(scan.points[i].y_m, scan.points[i].x_m);
    find_slopes(scan);
    find_sectors(scan, turns, motion);
    fill(scan, turns);
}

void RangeView::find_slopes(const lidar::SpinningScan& scan) {
    std::size_t most = 0;
    for (std::size_t ring = 0; ring < scan.rings(); ++ring) {
        const std::uint32_t begin = scan.ring_begin[ring], end = scan.ring_begin[ring + 1];
        most = std::max<std::size_t>(most, end - begin);
        double sum = 0;
        for (std::uint32_t i = begin; i < end; ++i) {
            const auto& p = scan.points[i];
            sum += p.z_m / std::sqrt(p.x_m * p.x_m + p.y_m * p.y_m);
        }
        // A ring without returns stays where it does no harm: with the one above it.
        const float above = slopes_.empty() ? 10.0f : slopes_.back();
        slopes_.push_back(end > begin ? std::min(above, static_cast<float>(sum / (end - begin))) : above);
    }
    columns_ = std::clamp(static_cast<int>(most), fewest_columns, most_columns);
    first_slope_ = slopes_.front();
    bins_per_slope_ = bins / std::max(1e-6f, slopes_.front() - slopes_.back());
    ring_at_.resize(bins + 1);
    int ring = -1;
    for (int bin = 0; bin <= bins; ++bin) {
        const float upper = first_slope_ - static_cast<float>(bin) / bins_per_slope_;
        while (ring + 1 < rings() && slopes_[static_cast<std::size_t>(ring + 1)] > upper) ++ring;
        ring_at_[static_cast<std::size_t>(bin)] = static_cast<std::int16_t>(ring);
    }
}

/// The pose of each sector is that of the mean time of its returns; a sector without any takes its
/// neighbour's.
void RangeView::find_sectors(const lidar::SpinningScan& scan, const std::vector<float>& turns,
                             const SweepMotion& motion) {
    std::vector<double> time_s(sectors, 0);
    std::vector<int> count(sectors, 0);
    for (std::size_t i = 0; i < turns.size(); ++i) {
        const lidar::SpinningPoint& p = scan.points[i];
        const auto sector = static_cast<std::size_t>(part_of_turn(turns[i], sectors));
        // The sweep begins within a sector: what is of its end must not count with what is of its beginning.
        if (count[sector] > 0 &&
            std::abs(p.time_s - time_s[sector] / count[sector]) > 0.5 * (scan.end_s - scan.begin_s))
            continue;
        time_s[sector] += p.time_s;
        ++count[sector];
    }
    sectors_.resize(sectors);
    for (std::size_t s = 0; s < sectors_.size(); ++s) {
        std::size_t from = s;
        for (std::size_t k = 0; k < sectors_.size() && count[from] == 0; ++k) from = (from + 1) % sectors;
        const double at_s = count[from] > 0 ? time_s[from] / count[from] : (scan.begin_s + scan.end_s) / 2;
        Eigen::Matrix3f R_map_lidar;
        motion.at(static_cast<float>(at_s), R_map_lidar, sectors_[s].from_origin_m);
        sectors_[s].R_lidar_map = R_map_lidar.transpose();
    }
}

/// The nearest return of each cell.
void RangeView::fill(const lidar::SpinningScan& scan, const std::vector<float>& turns) {
    ranges_.assign(static_cast<std::size_t>(columns_) * slopes_.size(), 0);
    for (std::size_t ring = 0; ring < scan.rings(); ++ring)
        for (std::uint32_t i = scan.ring_begin[ring]; i < scan.ring_begin[ring + 1]; ++i) {
            const auto& p = scan.points[i];
            const int column = part_of_turn(turns[i], columns_);
            const float range_m = std::sqrt(p.x_m * p.x_m + p.y_m * p.y_m + p.z_m * p.z_m);
            const auto range = static_cast<std::uint16_t>(std::min(range_m / range_unit_m, 65535.0f));
            std::uint16_t& cell =
                ranges_[ring * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(column)];
            if (cell == 0 || range < cell) cell = range;
        }
}

int RangeView::ring_above(float slope) const {
    if (slope >= first_slope_) return -1;
    const float bin = (first_slope_ - slope) * bins_per_slope_;
    int ring = ring_at_[static_cast<std::size_t>(std::min(bin, static_cast<float>(bins)))];
    while (ring + 1 < rings() && slopes_[static_cast<std::size_t>(ring + 1)] > slope) ++ring;
    return ring;
}

Evidence RangeView::look(const Eigen::Vector3f& from_origin_m, const ViewSettings& settings) const {
    const auto reach_m = static_cast<float>(settings.reach_m);
    if (from_origin_m.squaredNorm() > reach_m * reach_m) return Evidence::none;
    // The direction tells when the lidar looked there, and so from where: asked for twice, from nearby.
    Eigen::Vector3f p = sectors_[0].R_lidar_map * from_origin_m;
    float turns = azimuth_turns(p.y(), p.x());
    for (int round = 0, sector = -1; round < 2; ++round) {
        const int found = part_of_turn(turns, sectors);
        if (found == sector) break;
        sector = found;
        const Sector& s = sectors_[static_cast<std::size_t>(sector)];
        p = s.R_lidar_map * (from_origin_m - s.from_origin_m);
        turns = azimuth_turns(p.y(), p.x());
    }
    const float level_m = std::sqrt(p.x() * p.x() + p.y() * p.y());
    const float slope = p.z() / std::max(level_m, 1e-3f), off = static_cast<float>(settings.sigma_slope);
    const int upper = ring_above(slope + off);
    if (upper < 0 || upper + 1 >= rings()) return Evidence::none;
    int lower = upper + 1;
    while (lower + 1 < rings() && slopes_[static_cast<std::size_t>(lower)] > slope - off) ++lower;
    const float range_m = std::sqrt(p.squaredNorm());
    const float margin_m = static_cast<float>(settings.margin_m + settings.margin_per_m * range_m);
    const auto beyond = static_cast<int>((range_m + margin_m) / range_unit_m),
               before = static_cast<int>((range_m - margin_m) / range_unit_m);
    const int column = part_of_turn(turns, columns_);
    int returns = 0, there = 0, nearer = 0;
    for (int row = upper; row <= lower; ++row)
        for (int c = column - 1; c <= column + 1; ++c) {
            const int wrapped = c < 0 ? c + columns_ : c >= columns_ ? c - columns_ : c;
            const int range = ranges_[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
                                      static_cast<std::size_t>(wrapped)];
            if (range == 0) continue;
            ++returns;
            if (range < before)
                ++nearer;
            else if (range <= beyond)
                ++there;
        }
    if (there > 0) return Evidence::seen;
    return nearer == 0 && returns >= fewest_returns ? Evidence::through : Evidence::none;
}

}  // namespace loopline::cloud_map
