/// loopline: from a rawlog and an .ini to a trajectory, a map, pictures and figures.
#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>
#include <vector>

#include "commands/check.h"
#include "commands/describe.h"
#include "commands/evaluate.h"
#include "commands/import.h"
#include "commands/render.h"
#include "commands/run.h"
#include "config/problems.h"

using namespace loopline;

int main(int argc, char** argv) {
    CLI::App app{
        "Loopline: headless mobile mapping. One command turns a rawlog and an .ini into a trajectory, a map, "
        "pictures and figures."};
    app.require_subcommand(1);
    app.set_version_flag("--version", LOOPLINE_VERSION);
    app.footer(
        "Exit codes: 0 done; 2 configuration; 3 input data; 4 the estimate diverged or was refused; "
        "130 interrupted (results so far are saved).");

    std::vector<std::unique_ptr<Command>> commands;
    commands.push_back(make_run_command());
    commands.push_back(make_evaluate_command());
    commands.push_back(make_render_command());
    commands.push_back(make_check_command());
    commands.push_back(make_describe_command());
    commands.push_back(make_import_command());

    Command* chosen = nullptr;
    for (const auto& command : commands) {
        auto* sub = app.add_subcommand(command->name(), command->sentence());
        command->declare(*sub);
        sub->callback([&chosen, &command] { chosen = command.get(); });
    }

    try {
        app.parse(argc, argv);
        return chosen->run();
    } catch (const CLI::ParseError& e) {
        return app.exit(e) == 0 ? exit_done : exit_configuration;
    } catch (const ConfigurationError& e) {
        std::cerr << e.what() << '\n';  // each line opens on its file:line, for editors to jump to
        return e.code();
    } catch (const CommandError& e) {
        std::cerr << "loopline: " << e.what() << '\n';
        return e.code();
    } catch (const std::exception& e) {
        std::cerr << "loopline: " << e.what() << '\n';
        return exit_configuration;
    }
}
