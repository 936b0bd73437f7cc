/// Returns in the data packets of a Velodyne, each at the time when its laser was fired.
#pragma once

#include <cstdint>
#include <vector>

#include "lidar/spinning_scan.h"

namespace mrpt::obs {
class CObservationVelodyneScan;
}

namespace loopline::lidar {

/// Keeps its memory from scan to scan.
///
/// By the user manuals of VLP-16 and HDL-32E: a firing of 16 lasers takes 55.296 us, 2.304 us each, and two
/// of them are in a block; one of 32 lasers takes 46.08 us, 1.152 us each. A block tells the azimuth of its
/// first firing; what comes later in it is as much farther on as the lidar has turned by then. (MRPT 2.5's
/// own function takes the first 16 of the 32 returns of a block, and gives all of a packet its time.) Of an
/// HDL-64, a pair of blocks, upper and lower lasers, counts as one moment. Of two returns of a beam the last
/// is taken, which the block in front has.
class VelodynePackets {
 public:
    /// False, and nothing in `scan`, if there is no calibration. Rings are from the highest laser to the
    /// lowest. `intensity` of each point, if wanted, as SpinningScanReader::read()'s.
    bool read(const mrpt::obs::CObservationVelodyneScan& packets, SpinningScan& scan,
              std::vector<std::uint16_t>* intensity);

 private:
    struct Laser {
        std::vector<SpinningPoint> points;
        std::vector<std::uint16_t> intensity;
    };
    std::vector<Laser> lasers_;
};

}  // namespace loopline::lidar
