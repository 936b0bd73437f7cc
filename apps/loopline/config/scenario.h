/// A scenario: what one .ini file, with its overrides, tells a simulator. Everything is read and checked
/// before anything is simulated.
#pragma once

#include <string>
#include <vector>

#include "api/simulator.h"

namespace loopline {

/// Reads the file and `overrides` ("section.key=value") into the variables that the simulator's sections are
/// bound to, and returns the effective scenario: every key with its value, as a commented .ini that reads
/// back to the same. All problems are reported together, one sentence a line with file:line and the nearest
/// known name, in one ConfigurationError.
std::string load_scenario(const std::string& path, const std::vector<std::string>& overrides,
                          Simulator& simulator);

}  // namespace loopline
