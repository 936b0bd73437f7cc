#include "config/scenario.h"

#include <filesystem>

#include "config/ini_file.h"
#include "config/ini_text.h"
#include "config/section_reader.h"

namespace loopline {
namespace {

std::vector<std::string> keys_that_may_repeat(const std::vector<ParameterTable>& tables) {
    std::vector<std::string> keys;
    for (const auto& table : tables)
        for (const auto& parameter : table.parameters())
            if (parameter.kind == ParameterKind::rows) keys.push_back(table.section() + "." + parameter.name);
    return keys;
}

/// The place that a simulator's complaint is about; the file's start if it does not stand there.
Origin origin_of(IniFile& file, const ScenarioProblem& problem) {
    auto* section = file.find(problem.section);
    if (!section) return {file.path + ":1", 1};
    std::size_t row = 0;
    for (const auto& entry : section->entries)
        if (entry.key == problem.key && row++ == problem.row) return entry.origin;
    return section->origin;
}

}  // namespace

std::string load_scenario(const std::string& path, const std::vector<std::string>& overrides,
                          Simulator& simulator) {
    const std::vector<ParameterTable> tables = simulator.sections();
    IniFile file = read_ini_file(path, keys_that_may_repeat(tables));
    if (file.sections.empty() && !file.problems.empty()) throw ConfigurationError(file.problems);
    if (auto* run = file.find("run"))
        throw ConfigurationError({{run->origin,
                                   "a scenario has no section [run]; this is an experiment, for "
                                   "`loopline run`"}});
    for (const auto& assignment : overrides) apply_override(file, assignment);

    std::vector<Problem> problems = file.problems;
    DeclaredSections sections;
    for (const auto& table : tables) sections.emplace(table.section(), DeclaredSection{nullptr, table, true});
    for (const auto& section : file.sections)
        read_section(section, sections, std::filesystem::path(path).parent_path(), problems);
    if (problems.empty())
        for (const auto& problem : simulator.check_scenario())
            problems.emplace_back(origin_of(file, problem), "[" + problem.section + "] " + problem.key +
                                                                (problem.key.empty() ? "" : " ") +
                                                                problem.sentence);
    if (!problems.empty()) throw ConfigurationError(problems);

    std::string text =
        "# Effective scenario of loopline " LOOPLINE_VERSION ": every key with the value that counts.\n";
    for (const auto& table : tables) text += "\n" + ini_section_text(table);
    return text;
}

}  // namespace loopline
