#pragma once

#include <memory>

#include "commands/command.h"

namespace loopline {
std::unique_ptr<Command> make_simulate_command();
}  // namespace loopline
