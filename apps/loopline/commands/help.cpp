#include "commands/help.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <sstream>
#include <utility>
#include <vector>

#include "commands/terminal.h"

namespace loopline {
namespace {

/// CLI11 makes up type names such as FLOAT:POSITIVE or ENUM:value in {...}: said in a word.
std::string value_word(const CLI::Option& option) {
    if (const std::string& chosen = option.get_option_text(); !chosen.empty()) return chosen;
    const std::string type = option.get_type_name();
    const auto is = [&](const std::string& name) { return type == name || type.rfind(name + ":", 0) == 0; };
    if (is("FLOAT")) return "NUMBER";
    if (is("INT") || is("UINT")) return "N";
    if (is("ENUM")) return "WORD";
    if (is("TEXT") || is("")) return "TEXT";
    return type;
}

bool takes_value(const CLI::Option& option) {
    return option.get_items_expected_max() > 0;
}
bool may_repeat(const CLI::Option& option) {
    return takes_value(option) && (option.get_items_expected_max() > 1 || option.get_allow_extra_args());
}

/// "--rawlog FILE": how it is written, without brackets.
std::string written(const CLI::Option& option) {
    if (!option.nonpositional()) return option_word(option);
    std::string names;
    for (const auto& name : option.get_snames()) names += (names.empty() ? "-" : ", -") + name;
    for (const auto& name : option.get_lnames()) names += (names.empty() ? "--" : ", --") + name;
    return takes_value(option) ? names + " " + value_word(option) : names;
}

std::vector<const CLI::Option*> listed_options(const CLI::App& app, bool positional) {
    return app.get_options([positional](const CLI::Option* option) {
        return !option->get_group().empty() && option->nonpositional() != positional;
    });
}

/// One word per argument; a whole argument must not be broken over two lines.
std::string usage(const CLI::App& app, std::size_t width) {
    std::vector<std::string> parts;
    for (const auto* option : listed_options(app, true)) {
        const std::string word = option_word(*option) + (may_repeat(*option) ? "..." : "");
        parts.push_back(option->get_required() ? word : "[" + word + "]");
    }
    if (!app.get_subcommands({}).empty()) parts.emplace_back("COMMAND ...");
    for (const auto* option : listed_options(app, false)) {
        if (option == app.get_help_ptr()) continue;
        const std::string name =
            option_word(*option) + (takes_value(*option) ? " " + value_word(*option) : "");
        parts.push_back((option->get_required() ? name : "[" + name + "]") +
                        (may_repeat(*option) ? "..." : ""));
    }
    std::string text = "  " + command_name(app);
    std::size_t column = text.size();
    const std::size_t indent = width < 60 ? 5 : column;
    for (const auto& part : parts) {
        if (column + 1 + display_width(part) >= width && column > indent) {
            text += "\n" + std::string(indent, ' ');
            column = indent;
        }
        text += " " + part;
        column += 1 + display_width(part);
    }
    return text + "\n";
}

using Rows = std::vector<std::pair<std::string, std::string>>;

/// Two columns; on a narrow terminal the second stands under the first.
std::string two_columns(const Rows& rows, std::size_t width) {
    std::size_t left = 0;
    for (const auto& [name, text] : rows) left = std::max(left, display_width(name));
    const std::size_t start = left + 4;
    const bool stacked = start + 30 > width;
    std::string result;
    for (const auto& [name, text] : rows) {
        if (stacked)
            result += "  " + name + "\n" + std::string(6, ' ') + wrapped(text, width, 6, 6) + "\n";
        else
            result += padded("  " + name, start) + wrapped(text, width, start, start) + "\n";
    }
    return result;
}

Rows option_rows(const std::vector<const CLI::Option*>& options) {
    Rows rows;
    for (const auto* option : options) {
        const std::string remark = option->get_required() && option->nonpositional() ? " (required)" : "";
        rows.emplace_back(written(*option), option->get_description() + remark);
    }
    return rows;
}

/// Paragraphs, wrapped; a line that starts with a blank (an example to copy) stays whole.
std::string footer_text(const std::string& footer, std::size_t width) {
    std::string text;
    std::istringstream lines(footer);
    for (std::string line; std::getline(lines, line);)
        text += (line.rfind(' ', 0) == 0 ? line : wrapped(line, width, 0, 0)) + "\n";
    return text;
}

}  // namespace

std::string command_name(const CLI::App& app) {
    return app.get_parent() ? command_name(*app.get_parent()) + " " + app.get_name() : "loopline";
}

std::string option_word(const CLI::Option& option) {
    if (option.nonpositional())
        return option.get_lnames().empty() ? "-" + option.get_snames().front()
                                           : "--" + option.get_lnames().front();
    const std::string type = option.get_type_name();
    const std::string word = value_word(option);
    const bool made_up = word != type || word == "TEXT";
    std::string name = made_up ? option.get_name(true) : word;
    if (made_up)
        std::transform(name.begin(), name.end(), name.begin(),
                       [](unsigned char c) { return std::toupper(c); });
    return name;
}

std::string help_text(const CLI::App& app, std::size_t width) {
    std::string text = wrapped(app.get_description(), width, 0, 0) + "\n\nUsage:\n" + usage(app, width);
    Rows commands;
    for (const auto* sub : app.get_subcommands({}))
        commands.emplace_back(sub->get_name(), sub->get_description());
    if (!commands.empty()) text += "\nCommands:\n" + two_columns(commands, width);
    Rows rows = option_rows(listed_options(app, true));
    const Rows options = option_rows(listed_options(app, false));
    if (!rows.empty()) text += "\nArguments:\n" + two_columns(rows, width);
    if (!options.empty()) text += "\nOptions:\n" + two_columns(options, width);
    if (const auto footer = app.get_footer(); !footer.empty()) text += "\n" + footer_text(footer, width);
    return text;
}

}  // namespace loopline
