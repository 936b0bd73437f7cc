#include "config/problems.h"

#include <algorithm>

namespace loopline {
namespace {

/// In the order of the file, the command line last.
std::vector<Problem> in_order(std::vector<Problem> problems) {
    std::stable_sort(problems.begin(), problems.end(), [](const Problem& a, const Problem& b) {
        if ((a.origin.line == 0) != (b.origin.line == 0)) return b.origin.line == 0;
        return a.origin.line < b.origin.line;
    });
    return problems;
}

std::string as_lines(const std::vector<Problem>& problems) {
    std::string lines;
    for (const auto& problem : in_order(problems))
        lines += (lines.empty() ? "" : "\n") + problem.origin.text + ": " + problem.sentence;
    return lines;
}

ExitCode code_of(const std::vector<Problem>& problems) {
    const bool only_data = std::all_of(problems.begin(), problems.end(),
                                       [](const Problem& p) { return p.code == exit_input_data; });
    return only_data ? exit_input_data : exit_configuration;
}

}  // namespace

ConfigurationError::ConfigurationError(std::vector<Problem> problems)
    : CommandError(code_of(problems), as_lines(problems)), problems_(in_order(std::move(problems))) {}

}  // namespace loopline
