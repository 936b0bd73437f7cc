/// The table of subcommands: each declares its arguments on a CLI11 subcommand and runs.
#pragma once

#include <stdexcept>
#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace loopline {

/// How the program ends; see `loopline --help`.
enum ExitCode : int { exit_done = 0, exit_configuration = 2, exit_input_data = 3, exit_refused = 4, exit_interrupted = 130 };

/// Ends a command with one or more sentences (a line each) and an exit code. Thrown before anything was written, or
/// after everything worth keeping was.
class CommandError : public std::runtime_error {
   public:
    CommandError(ExitCode code, const std::string& sentences) : std::runtime_error(sentences), code_(code) {}
    ExitCode code() const { return code_; }

   private:
    ExitCode code_;
};

/// One subcommand: `declare` adds options to its CLI11 app, `run` is called after they were parsed.
class Command {
   public:
    virtual ~Command() = default;
    virtual std::string name() const = 0;
    virtual std::string sentence() const = 0;
    virtual void declare(CLI::App& app) = 0;
    virtual ExitCode run() = 0;
};

}  // namespace loopline
