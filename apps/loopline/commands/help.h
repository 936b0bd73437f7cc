/// What `--help` prints.
#pragma once

#include <string>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace loopline {

/// The program's help, or that of one subcommand, for a terminal of `width` columns.
std::string help_text(const CLI::App& app, std::size_t width);

/// "loopline import carmen"
std::string command_name(const CLI::App& app);

/// "CONFIG.ini" or "--rawlog": what a person would call the option.
std::string option_word(const CLI::Option& option);

}  // namespace loopline
