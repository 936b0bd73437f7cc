#include "commands/describe.h"

#include <CLI/CLI.hpp>

namespace loopline {
namespace {

class DescribeCommand : public Command {
   public:
    std::string name() const override { return "describe"; }
    std::string sentence() const override { return "not there yet"; }
    void declare(CLI::App&) override {}
    ExitCode run() override { throw CommandError(exit_configuration, "loopline describe is not there yet"); }
};

}  // namespace

std::unique_ptr<Command> make_describe_command() { return std::make_unique<DescribeCommand>(); }

}  // namespace loopline
