/// What no observation may carry into the chain: a damaged or careless log can hold numbers that parse and
/// yet break whatever computes with them.
#pragma once

#include <mrpt/obs/CObservation.h>

namespace loopline {

/// Why the observation must not be used, as a plural clause ("scans without a usable aperture"); null if it
/// may be. Ranges that are NaN, infinite, not positive or absurd are marked invalid in a scan that is
/// otherwise fine.
const char* refusal_of(mrpt::obs::CObservation& observation);

}  // namespace loopline
