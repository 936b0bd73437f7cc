#include "commands/import.h"

#include <CLI/CLI.hpp>

namespace loopline {
namespace {

class ImportCommand : public Command {
   public:
    std::string name() const override { return "import"; }
    std::string sentence() const override { return "not there yet"; }
    void declare(CLI::App&) override {}
    ExitCode run() override { throw CommandError(exit_configuration, "loopline import is not there yet"); }
};

}  // namespace

std::unique_ptr<Command> make_import_command() { return std::make_unique<ImportCommand>(); }

}  // namespace loopline
