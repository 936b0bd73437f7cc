#include "commands/check.h"

#include <CLI/CLI.hpp>

namespace loopline {
namespace {

class CheckCommand : public Command {
   public:
    std::string name() const override { return "check"; }
    std::string sentence() const override { return "not there yet"; }
    void declare(CLI::App&) override {}
    ExitCode run() override { throw CommandError(exit_configuration, "loopline check is not there yet"); }
};

}  // namespace

std::unique_ptr<Command> make_check_command() { return std::make_unique<CheckCommand>(); }

}  // namespace loopline
