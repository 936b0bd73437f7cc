/// What is wrong with a configuration: collected, then reported all together.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "commands/command.h"

namespace loopline {

/// Where a setting came from.
struct Origin {
    std::string text;  ///< "run.ini:12", or "--set section.key=value"
    int line = 0;      ///< in the file; 0 for the command line
};

struct Problem {
    Problem(Origin where, std::string what, ExitCode how = exit_configuration)
        : origin(std::move(where)), sentence(std::move(what)), code(how) {}

    Origin origin;
    std::string sentence;
    ExitCode code;  ///< exit_input_data for a log that is not there
};

/// Several sentences, each a line that opens on its origin, so that editors jump to it. The exit code is that
/// of input data only if nothing else is wrong.
class ConfigurationError : public CommandError {
 public:
    explicit ConfigurationError(std::vector<Problem> problems);
    const std::vector<Problem>& problems() const { return problems_; }

 private:
    std::vector<Problem> problems_;
};

}  // namespace loopline
