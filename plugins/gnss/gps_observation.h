/// Fixes from and to MRPT's observations.
#pragma once

#include <mrpt/obs/CObservationGPS.h>

#include "gnss/gnss_fix.h"

namespace loopline::gnss {

/// What an observation says of the antenna's place; `stamp_ns` is its stamp in the log. Position, quality,
/// satellites and HDOP are those of GGA, else of NovAtel's BESTPOS, else of RMC. Standard deviations are
/// those of BESTPOS: MRPT 2.5 has no message for GST, and its CObservationGPS no covariance. None if there is
/// none of the three, or they hold numbers that can't be; a receiver without a fix gives one of invalid
/// quality.
std::optional<GnssFix> fix_from_mrpt(const mrpt::obs::CObservationGPS& observation, StampNs stamp_ns);

/// The observation of a fix: GGA with the height as altitude and geoid, RMC where speed or course are known
/// (or nothing but place), VDOP as GSA, standard deviations as BESTPOS and the heading of two antennas as
/// INSPVAS. The stamp is the fix's, to the 100 ns that MRPT counts.
mrpt::obs::CObservationGPS::Ptr gps_observation(const GnssFix& fix, const std::string& label);

}  // namespace loopline::gnss
