/// From the words of the command line to a command that has run: help, misspelt words, errors and exit codes.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "commands/command.h"

namespace loopline {

/// A reader that has seen enough (`loopline describe | head -1`) must not end a run before its results are
/// saved: from now on, writing to a closed pipe fails in silence. Call once, first.
void survive_closed_pipes();

/// `words` without the program's name. Returns the exit code; never throws.
int run_command_line(const std::vector<std::unique_ptr<Command>>& commands, std::vector<std::string> words);

}  // namespace loopline
