#include "commands/evaluate.h"

#include <CLI/CLI.hpp>

namespace loopline {
namespace {

class EvaluateCommand : public Command {
   public:
    std::string name() const override { return "evaluate"; }
    std::string sentence() const override { return "not there yet"; }
    void declare(CLI::App&) override {}
    ExitCode run() override { throw CommandError(exit_configuration, "loopline evaluate is not there yet"); }
};

}  // namespace

std::unique_ptr<Command> make_evaluate_command() { return std::make_unique<EvaluateCommand>(); }

}  // namespace loopline
