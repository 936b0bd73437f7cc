#include "commands/render.h"

#include <CLI/CLI.hpp>

namespace loopline {
namespace {

class RenderCommand : public Command {
   public:
    std::string name() const override { return "render"; }
    std::string sentence() const override { return "not there yet"; }
    void declare(CLI::App&) override {}
    ExitCode run() override { throw CommandError(exit_configuration, "loopline render is not there yet"); }
};

}  // namespace

std::unique_ptr<Command> make_render_command() { return std::make_unique<RenderCommand>(); }

}  // namespace loopline
