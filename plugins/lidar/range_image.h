/// Ranges by beam and column, and the points that they stand for.
#pragma once

#include <cstdint>
#include <vector>

#include "lidar/spinning_scan.h"

namespace loopline::lidar {

/// Angles and times of a range image, by the convention of MRPT's CObservationRotatingScan: column k of n has
/// the azimuth first + span k / (n - 1), and the time sweep k / (n - 1) after the stamp, which is that of the
/// first column.
struct RangeImageGeometry {
    int columns = 0;
    double first_azimuth_rad = 0;          ///< counter-clockwise from the x axis
    double azimuth_span_rad = 0;           ///< to the last column; negative: the lidar turns clockwise
    double sweep_s = 0;                    ///< to the last column
    double range_unit_m = 0;               ///< what a range of 1 stands for
    std::vector<double> elevations_deg{};  ///< of each row, up positive

    double part(int column) const { return columns > 1 ? static_cast<double>(column) / (columns - 1) : 0; }
    double azimuth_rad(int column) const { return first_azimuth_rad + azimuth_span_rad * part(column); }
    double time_s(int column) const { return sweep_s * part(column); }
};
bool same(const RangeImageGeometry& a, const RangeImageGeometry& b);

/// Keeps the sines and cosines from scan to scan.
class RangeImageReader {
 public:
    /// Points of all ranges that are not 0, into `scan.points` and `scan.ring_begin`. `ranges`: row by row,
    /// of which each begins `stride` after the one before.
    void read(const RangeImageGeometry& geometry, const std::uint16_t* ranges, std::size_t stride,
              SpinningScan& scan);

 private:
    struct Column {
        float cosine, sine, time_s;
    };
    struct Row {
        std::size_t row;
        float cosine_m, sine_m;  ///< of its elevation, times the unit of ranges
    };
    void prepare(const RangeImageGeometry& geometry);

    RangeImageGeometry geometry_;
    std::vector<Column> columns_;
    std::vector<Row> rows_;  ///< from the highest to the lowest
};

}  // namespace loopline::lidar
