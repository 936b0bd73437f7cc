#pragma once

#include <memory>

#include "commands/command.h"

namespace loopline {

std::unique_ptr<Command> make_calibrate_command();

}  // namespace loopline
