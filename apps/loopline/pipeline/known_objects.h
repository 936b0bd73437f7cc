/// Planar scans and odometry make up most of a log. MRPT reads an object field by field, each through two
/// virtual calls, finds its class by name, and makes it anew, though the last one of its kind has just become
/// free: together that costs more than unpacking the bytes. This reads the present versions of the two
/// classes straight from the bytes, into objects that are free again. The result is the one that
/// CArchive::ReadObject() gives, to the bit; whatever is not exactly as MRPT writes it is left to
/// ReadObject().
#pragma once

#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CObservationOdometry.h>

#include <cstddef>
#include <vector>

#include "api/observation_pool.h"

namespace loopline {

class KnownObjects {
 public:
    struct Reading {
        mrpt::obs::CObservation::Ptr object;  ///< null: not one of these
        std::size_t size = 0;  ///< of the object in bytes; without it, how many bytes could tell
    };
    /// The object that begins at `bytes`, of which `size` can be looked at.
    Reading read(const unsigned char* bytes, std::size_t size);

 private:
    mrpt::obs::CObservation2DRangeScan::Ptr free_scan();

    std::vector<float> ranges_m_;  ///< of the scan at work
    // Modules look back at a handful of scans.
    ObservationPool<mrpt::obs::CObservation2DRangeScan, 16> scans_;
    ObservationPool<mrpt::obs::CObservationOdometry, 16> odometry_;
};

}  // namespace loopline
