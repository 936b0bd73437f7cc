/// A second of stamps.
#pragma once

#include "api/stamp.h"

namespace loopline::test {

constexpr StampNs second_ns = 1'000'000'000;

}  // namespace loopline::test
