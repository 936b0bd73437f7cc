#include "importers/csv_map.h"

#include <algorithm>
#include <filesystem>

#include "api/attitude.h"
#include "config/did_you_mean.h"
#include "config/paths.h"
#include "config/section_reader.h"

namespace loopline::csv {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> kind_names() {
    std::vector<std::string> names;
    for (const auto& [name, kind] : kinds()) names.push_back(name);
    return names;
}

void read_section_of(ColumnMap& map, IniSection& written, std::vector<Problem>& problems) {
    auto section = std::make_unique<Section>(written.name);
    const IniEntry* kind = written.find("kind");
    const auto& all = kinds();
    const auto found = !kind ? all.end() : std::find_if(all.begin(), all.end(), [kind](const auto& known) {
        return known.first == kind->value;
    });
    if (found == all.end()) {
        const auto choice =
            kind ? did_you_mean(kind->value, kind_names(), "; it is one of " + listing(kind_names()))
                 : "; it is one of " + listing(kind_names());
        problems.emplace_back(kind ? kind->origin : written.origin,
                              "[" + written.name + "] kind " +
                                  (kind ? "can't be \"" + kind->value + "\"" : "is missing") + choice);
        return;
    }
    section->kind = found->second;
    const std::size_t before = problems.size();
    read_section(written, {{written.name, {nullptr, section->table(), true}}}, {}, problems);
    for (ColumnKey& column : section->columns) {
        if (column.text.empty()) continue;
        const auto parsed = column_from_text(column.text, column.quantity);
        column.choice = parsed.choice;
        if (!parsed.problem.empty())
            problems.emplace_back(written.find(column.key)->origin,
                                  "[" + written.name + "] " + column.key + " " + parsed.problem);
    }
    if (problems.size() == before) check_section(map, *section, problems);
    map.sections.push_back(std::move(section));
}

void check_clock(ColumnMap& map, std::vector<Problem>& problems) {
    const auto& from = map.clock.utc_from;
    const IniSection* written = map.ini.find("clock");
    if (from.empty() || !written) return;
    std::vector<std::string> able;
    for (const auto& section : map.sections)
        if (section->kind == Kind::gnss && section->has("utc")) able.push_back(section->name);
    if (std::find(able.begin(), able.end(), from) == able.end())
        problems.emplace_back(map.ini.find("clock")->find("utc_from")->origin,
                              "[clock] utc_from names no GNSS section with a column utc: \"" + from + "\"" +
                                  did_you_mean(from, able, "; there is " + listing(able)));
}

/// Where the maps lie that come with the program: beside the build folder's tree, or where they are
/// installed.
std::vector<fs::path> map_folders() {
    const fs::path bin = program_file().parent_path();
    return {bin.parent_path().parent_path().parent_path() / "datasets" / "columns",
            bin.parent_path() / "share" / "loopline" / "columns"};
}

}  // namespace

const ColumnKey* Section::column(const std::string& key) const {
    for (const ColumnKey& column : columns)
        if (column.key == key) return column.text.empty() ? nullptr : &column;
    return nullptr;
}

bool Section::has_all(const std::vector<std::string>& keys) const {
    return std::all_of(keys.begin(), keys.end(), [this](const auto& key) { return has(key); });
}

bool Section::has_any(const std::vector<std::string>& keys) const {
    return std::any_of(keys.begin(), keys.end(), [this](const auto& key) { return has(key); });
}

Pose3 Section::T_base_sensor() const {
    return {{x_m, y_m, z_m}, attitude(yaw_rad, pitch_rad, roll_rad)};
}

Origin ColumnMap::origin(const Section& section, const std::string& key) {
    IniSection* written = ini.find(section.name);
    if (!written) return {path + ":1", 1};
    const IniEntry* entry = written->find(key);
    return entry ? entry->origin : written->origin;
}

ColumnMap read_column_map(const std::string& path) {
    ColumnMap map;
    map.path = path;
    map.ini = read_ini_file(path);
    std::vector<Problem> problems = map.ini.problems;
    for (IniSection& written : map.ini.sections)
        if (written.name == "clock")
            read_section(written, {{"clock", {nullptr, clock_table(map.clock), true}}}, {}, problems);
        else
            read_section_of(map, written, problems);
    if (problems.empty()) check_clock(map, problems);
    if (problems.empty() && map.sections.empty())
        problems.emplace_back(Origin{path + ":1", 1},
                              "there is no section of a sensor; write one, as in "
                              "datasets/columns");
    if (!problems.empty()) throw ConfigurationError(problems);
    return map;
}

std::string path_of_column_map(const std::string& name) {
    std::error_code none;
    if (fs::is_regular_file(name, none)) return name;
    std::vector<std::string> known;
    for (const fs::path& folder : map_folders()) {
        for (const auto& entry : fs::directory_iterator(folder, none))
            if (entry.path().extension() == ".ini") {
                known.push_back(entry.path().stem().string());
                if (known.back() == name) return entry.path().string();
            }
    }
    std::sort(known.begin(), known.end());
    throw CommandError(exit_configuration, "--columns " + name +
                                               " is no file, and no column map that comes with the program" +
                                               did_you_mean(name, known, "; those are " + listing(known)));
}

}  // namespace loopline::csv
