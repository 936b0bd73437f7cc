/// The catalogue for a terminal.
#include <algorithm>
#include <sstream>

#include "commands/terminal.h"
#include "config/catalogue.h"
#include "config/did_you_mean.h"
#include "config/ini_text.h"

namespace loopline {
namespace {

struct Row {
    std::string key, value, allowed, sentence;
};

std::string observations(const ModuleInfo& info) {
    std::string text;
    const auto add = [&](const std::string& verb, const std::vector<std::string>& classes) {
        if (!classes.empty()) text += (text.empty() ? "" : "; ") + verb + " " + listing(classes);
    };
    add("needs", info.needs);
    add("uses", info.uses);
    add("publishes", info.publishes);
    return text;
}

std::string group(const Catalogue& catalogue, SectionKind kind, const std::string& title, std::size_t width) {
    std::size_t left = 0;
    for (const auto& entry : catalogue.entries()) left = std::max(left, display_width(entry.info.name));
    const bool stacked = left + 34 > width;
    const std::size_t start = stacked ? 6 : left + 4;
    std::string text = wrapped(title, width, 0, 0) + "\n";
    bool any = false;
    for (const auto& entry : catalogue.entries()) {
        if (entry.kind != kind) continue;
        any = true;
        text += stacked ? "  " + entry.info.name + "\n" + std::string(start, ' ')
                        : padded("  " + entry.info.name, start);
        text += wrapped(entry.info.sentence, width, start, start) + "\n";
        if (const auto seen = observations(entry.info); !seen.empty())
            text += std::string(start, ' ') + wrapped(seen, width, start, start) + "\n";
    }
    return any ? text + "\n" : text + "  none\n\n";
}

std::vector<Row> rows_of(const ParameterTable& table) {
    std::vector<Row> rows;
    for (const auto& p : table.parameters()) {
        const std::string unit = p.unit.empty() || p.default_text.empty() ? "" : " " + p.unit;
        const std::string allowed = p.allowed.empty() ? kind_text(p.kind) : p.allowed;
        rows.push_back(
            {p.name, p.default_text.empty() ? "(empty)" : p.default_text + unit, allowed, p.sentence});
    }
    return rows;
}

std::vector<std::string> lines_of(const std::string& text, std::size_t width) {
    std::vector<std::string> lines;
    std::istringstream stream(wrapped(text, width, 0, 0));
    for (std::string line; std::getline(stream, line);) lines.push_back(line);
    return lines;
}

/// A row whose last two cells may take several lines.
std::string table_row(const Row& row, std::size_t key, std::size_t value, std::size_t allowed,
                      std::size_t width) {
    const std::size_t start = key + value + allowed + 8;
    const auto allowed_lines = lines_of(row.allowed, allowed + 1),
               sentence_lines = lines_of(row.sentence, width - start);
    std::string text;
    for (std::size_t i = 0; i < std::max(allowed_lines.size(), sentence_lines.size()); ++i) {
        std::string line =
            "  " + padded(i == 0 ? row.key : "", key + 2) + padded(i == 0 ? row.value : "", value + 2);
        line += padded(i < allowed_lines.size() ? allowed_lines[i] : "", allowed + 2);
        line += i < sentence_lines.size() ? sentence_lines[i] : "";
        text += line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
    }
    return text;
}

/// Columns while the sentences keep room, else each key over its sentence.
std::string parameter_rows(const std::vector<Row>& rows, std::size_t width) {
    constexpr std::size_t widest_allowed = 20, narrowest_sentence = 28;
    std::size_t key = 3, value = 7, allowed = 7;
    for (const auto& row : rows) {
        key = std::max(key, display_width(row.key));
        value = std::max(value, display_width(row.value));
        for (const auto& line : lines_of(row.allowed, widest_allowed))
            allowed = std::max(allowed, display_width(line));
    }
    std::string text;
    if (key + value + allowed + 8 + narrowest_sentence <= width) {
        text = table_row({"KEY", "DEFAULT", "ALLOWED", "WHAT"}, key, value, allowed, width);
        for (const auto& row : rows) text += table_row(row, key, value, allowed, width);
        return text;
    }
    for (const auto& row : rows) {
        const std::string head = "  " + row.key + " = " + row.value + "  ";
        text += head + wrapped("(" + row.allowed + ")", width, 6, display_width(head)) + "\n      " +
                wrapped(row.sentence, width, 6, 6) + "\n";
    }
    return text;
}

}  // namespace

std::string describe_all_as_text(const Catalogue& catalogue, std::size_t width) {
    return group(catalogue, SectionKind::module, "Modules, for [run] modules:", width) +
           group(catalogue, SectionKind::map_builder, "Map builders, for [run] maps:", width) +
           group(catalogue, SectionKind::host, "Other sections of an .ini:", width) +
           group(catalogue, SectionKind::scenario,
                 "Sections of a scenario, for `loopline simulate`:", width) +
           group(catalogue, SectionKind::import_file,
                 "Sections of a column map, for `loopline import csv`:", width) +
           wrapped(
               "`loopline describe NAME` shows the keys of one; --ini prints them as a commented .ini, "
               "--markdown as a "
               "page of the manual.",
               width, 0, 0) +
           "\n";
}

std::string describe_as_text(const CatalogueEntry& entry, std::size_t width) {
    const char* kinds[] = {"section of an .ini", "module", "map builder", "section of a scenario",
                           "section of a column map"};
    std::string text = wrapped("[" + entry.info.name + "], " + kinds[static_cast<int>(entry.kind)] + ": " +
                                   entry.info.sentence,
                               width, 2, 0) +
                       "\n";
    if (const auto seen = observations(entry.info); !seen.empty())
        text += "  " + wrapped(seen, width, 2, 2) + "\n";
    if (entry.table.parameters().empty()) return text + "\n  It has no keys.\n";
    return text + "\n" + parameter_rows(rows_of(entry.table), width);
}

}  // namespace loopline
