#include "config/ini_text.h"

#include "config/ini_file.h"

namespace loopline {

std::string ini_comment(const std::string& text) {
    constexpr std::size_t width = 100;
    std::string lines, line = "#";
    for (const auto& word : split_words(text, " ")) {
        if (line.size() + 1 + word.size() > width && line != "#") {
            lines += line + "\n";
            line = "#";
        }
        line += " " + word;
    }
    return lines + line + "\n";
}

std::string kind_text(ParameterKind kind) {
    switch (kind) {
        case ParameterKind::real:
            return "number";
        case ParameterKind::integer:
            return "whole number";
        case ParameterKind::boolean:
            return "switch";
        case ParameterKind::choice:
            return "choice";
        case ParameterKind::text:
            return "text";
        case ParameterKind::path:
            return "path";
        case ParameterKind::list:
            return "words";
        case ParameterKind::path_list:
            return "paths";
        case ParameterKind::rows:
            return "rows of numbers";
    }
    return {};
}

std::string parameter_facts(const Parameter& parameter) {
    std::string facts = kind_text(parameter.kind);
    if (!parameter.unit.empty()) facts += " in " + parameter.unit;
    if (!parameter.allowed.empty()) facts += ", " + parameter.allowed;
    if (!parameter.default_text.empty()) facts += ", default " + parameter.default_text;
    return facts;
}

std::string ini_section_text(const ParameterTable& table) {
    std::string text = ini_comment(table.sentence()) + "[" + table.section() + "]\n";
    for (const auto& parameter : table.parameters()) {
        text += "\n" + ini_comment(parameter.sentence + " (" + parameter_facts(parameter) + ")");
        if (parameter.kind != ParameterKind::rows)
            text += ini_assignment(parameter.name, parameter.print()) + "\n";
        else
            for (const auto& row : parameter.print_rows()) text += ini_assignment(parameter.name, row) + "\n";
    }
    return text;
}

}  // namespace loopline
