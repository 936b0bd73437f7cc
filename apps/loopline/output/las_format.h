/// LAS 1.2, point format 1 (ASPRS, LAS specification version 1.2, 2008): header, records and points.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

#include "api/stamp.h"
#include "output/output_file.h"

namespace loopline {

constexpr std::size_t most_las_points = 4'294'967'295;

/// A coordinate system by its number in the EPSG's registry.
struct LasCoordinateSystem {
    int projected_epsg = 0;
    std::string citation;  ///< what a person reads: "WGS 84 / UTM zone 32N"
};

struct LasHeader {
    StampNs first_ns = 0;  ///< its day is the file's: the same run gives the same bytes
    std::uint32_t points = 0;
    double unit_m = 1e-4;                                ///< of the points' whole numbers
    Eigen::Vector3d offset_m = Eigen::Vector3d::Zero();  ///< which they count from
    Eigen::Vector3d low_m = Eigen::Vector3d::Zero(), high_m = Eigen::Vector3d::Zero();
    const LasCoordinateSystem* system = nullptr;  ///< null: none
};

/// The header, and the coordinate system in records of GeoTIFF's keys.
void write_las_header(OutputFile& out, const LasHeader& header);
/// The box about all points once more, where only the end of the file tells it.
void overwrite_las_bounds(OutputFile& out, const Eigen::Vector3d& low_m, const Eigen::Vector3d& high_m);
/// The first return of one. `gps_time_s` as LasClock has it.
void write_las_point(OutputFile& out, const std::array<std::int32_t, 3>& place, std::uint16_t intensity,
                     double gps_time_s);

/// GPS time less 1e9 s, of seconds after a moment.
class LasClock {
 public:
    explicit LasClock(StampNs first_ns);
    double seconds(double after_first_s) const { return first_s_ + after_first_s; }

 private:
    double first_s_;
};

/// What GPS time is ahead of UTC then, in whole seconds: leap seconds since 1980, known up to 2017, when the
/// last one was put in.
int gps_ahead_of_utc_s(StampNs stamp_ns);

}  // namespace loopline
