#include "commands/run.h"

#include <CLI/CLI.hpp>

namespace loopline {
namespace {

class RunCommand : public Command {
   public:
    std::string name() const override { return "run"; }
    std::string sentence() const override { return "not there yet"; }
    void declare(CLI::App&) override {}
    ExitCode run() override { throw CommandError(exit_configuration, "loopline run is not there yet"); }
};

}  // namespace

std::unique_ptr<Command> make_run_command() { return std::make_unique<RunCommand>(); }

}  // namespace loopline
