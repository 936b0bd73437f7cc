/// What modules found out about their own parameters, as .ini text.
#pragma once

#include <string>

#include "api/module.h"

namespace loopline {

/// One section, ready to be used: each key under a comment with its standard error and what it rests on; what
/// is left out, with the reason, as comments. So is a value that `module` does not take.
std::string calibration_ini_text(const Calibration& calibration, Module& module);

}  // namespace loopline
