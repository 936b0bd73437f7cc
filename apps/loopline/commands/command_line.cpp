#include "commands/command_line.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <csignal>
#include <functional>
#include <iostream>
#include <new>

#include "commands/help.h"
#include "commands/terminal.h"
#include "config/did_you_mean.h"
#include "config/problems.h"

namespace loopline {
namespace {

volatile std::sig_atomic_t pipe_was_closed = 0;

std::string capitalised(std::string sentence) {
    if (!sentence.empty())
        sentence[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(sentence[0])));
    return sentence;
}

std::vector<std::string> command_names(const CLI::App& app) {
    std::vector<std::string> names;
    for (const auto* sub : app.get_subcommands({})) names.push_back(sub->get_name());
    return names;
}

std::vector<std::string> option_names(const CLI::App& app) {
    std::vector<std::string> names;
    for (const auto* option : app.get_options())
        if (option->nonpositional() && !option->get_lnames().empty()) names.push_back(option_word(*option));
    return names;
}

/// What stands wrong on the command line of `app`, as one sentence.
std::string complaint(const CLI::App& app, const CLI::ParseError& error) {
    for (const auto& word : app.remaining(true)) {
        const bool option = word.size() > 1 && word[0] == '-';
        const std::string name = word.substr(0, word.find('='));
        if (option) return "there is no option \"" + name + "\"" + did_you_mean(name, option_names(app));
        return "there is no place for the argument \"" + word + "\"";
    }
    for (const auto* option : app.get_options())
        if (option->get_required() && option->count() == 0) return option_word(*option) + " is missing";
    const std::string said = plain_message(error.what());
    if (dynamic_cast<const CLI::ArgumentMismatch*>(&error))
        return said.substr(0, said.find(':')) + " needs a value";
    const std::string conversion = "Could not convert: ";
    if (said.rfind(conversion, 0) == 0)
        return said.substr(conversion.size()) + " is not a value that it takes";
    return said;
}

/// What goes wrong ends in one sentence and an exit code.
int guarded(const std::function<int()>& work) {
    try {
        return work();
    } catch (const ConfigurationError& e) {
        std::cerr << e.what() << '\n';  // each line opens on its file:line, for editors to jump to
        return e.code();
    } catch (const CommandError& e) {
        std::cerr << "loopline: " << e.what() << '\n';
        return e.code();
    } catch (const std::bad_alloc&) {
        std::cerr << "loopline: there is not enough memory; try a shorter log or fewer maps\n";
    } catch (const std::exception& e) {
        std::cerr << "loopline: " << plain_message(e.what()) << '\n';
    }
    return exit_configuration;
}

/// The command that the words speak of, with the commands inside it: "import carmen".
const CLI::App& addressed_by(const std::vector<std::string>& words, const CLI::App& app) {
    const CLI::App* addressed = &app;
    for (const auto& word : words) {
        const auto subs =
            addressed->get_subcommands([&](const CLI::App* sub) { return sub->get_name() == word; });
        if (subs.empty()) break;
        addressed = subs.front();
    }
    return *addressed;
}

/// Parses and runs; `chosen` is set by the parser.
int parse_and_run(CLI::App& app, const std::vector<std::string>& words, Command* const& chosen) {
    try {
        app.parse(std::vector<std::string>(words.rbegin(), words.rend()));  // CLI11 takes them from the end
    } catch (const CLI::CallForHelp&) {
        std::cout << help_text(addressed_by(words, app), terminal_width()) << std::flush;
        return exit_done;
    } catch (const CLI::CallForVersion& e) {
        std::cout << e.what() << std::endl;
        return exit_done;
    } catch (const CLI::ParseError& e) {
        const CLI::App& addressed = addressed_by(words, app);
        const std::string name = command_name(addressed);
        std::cerr << name << ": " << complaint(addressed, e) << " (see " << name << " --help)\n";
        return exit_configuration;
    }
    const int code = chosen->run();
    if (!std::cout.flush() && !pipe_was_closed)
        throw CommandError(exit_configuration, "the output could not be written to its end");
    return code;
}

/// The words with "help run" turned into "run --help".
std::vector<std::string> normal(std::vector<std::string> words) {
    if (words.empty() || words[0] != "help") return words;
    words.erase(words.begin());
    words.emplace_back("--help");
    return words;
}

}  // namespace

void survive_closed_pipes() {
    std::signal(SIGPIPE, [](int) { pipe_was_closed = 1; });
}

int run_command_line(const std::vector<std::unique_ptr<Command>>& commands, std::vector<std::string> words) {
    CLI::App app{
        "Loopline: headless mobile mapping. One command turns a rawlog and an .ini into a trajectory, a map, "
        "pictures and figures."};
    app.set_help_flag("-h,--help", "Print this help; with a command before it, that of the command");
    app.set_version_flag("--version", "loopline " LOOPLINE_VERSION, "Print the version");
    app.require_subcommand(1);
    const std::string exit_codes =
        "Exit codes: 0 done; 2 configuration (command line, .ini, plugins, a place that can't be written); 3 "
        "input "
        "data; 4 the estimate diverged or was refused, or a module failed; 130 interrupted (results so far "
        "are "
        "saved); 137 killed from outside, as when memory runs out.";
    app.footer(exit_codes);  // the commands inherit it
    Command* chosen = nullptr;
    for (const auto& command : commands) {
        auto* sub = app.add_subcommand(command->name(), capitalised(command->sentence()));
        sub->set_help_flag("-h,--help", "Print this help");
        command->declare(*sub);
        sub->callback([&chosen, &command] { chosen = command.get(); });
    }
    app.footer(
        "For a start, from the folder of the sources:\n"
        "  loopline run ini/real/telecom_faculty_lines.ini --out runs/telecom\n\n" +
        exit_codes);

    if (words.empty()) {
        std::cerr << help_text(app, terminal_width());
        return exit_configuration;
    }
    words = normal(std::move(words));
    const auto names = command_names(app);
    const bool option_first = words[0][0] == '-';
    if (!option_first && std::find(names.begin(), names.end(), words[0]) == names.end()) {
        std::cerr << "loopline: there is no command \"" << words[0] << "\""
                  << did_you_mean(words[0], names, "; the commands are " + listing(names)) << '\n';
        return exit_configuration;
    }

    return guarded([&] { return parse_and_run(app, words, chosen); });
}

}  // namespace loopline
