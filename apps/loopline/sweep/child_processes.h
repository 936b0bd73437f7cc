/// This program's own commands in processes of their own, a few at a time.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace loopline {

struct ChildCommand {
    std::vector<std::string> arguments;  ///< of this program
    std::filesystem::path said;          ///< file for what it writes to stdout and stderr
};

/// How a command ended: its exit code, 128 + the signal's number if a signal ended it.
using ChildEnded = std::function<void(std::size_t index, int exit_code)>;

/// Runs the commands in their order, at most `at_once` at the same time, and tells of each that ended. Starts
/// no more once one was interrupted (exit code 130) or `go_on` says no, waits for those that run, and returns
/// how many were started. Throws CommandError if no process can be started.
std::size_t run_children(const std::vector<ChildCommand>& commands, std::size_t at_once,
                         const ChildEnded& ended, const std::function<bool()>& go_on);

}  // namespace loopline
