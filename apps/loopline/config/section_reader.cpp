#include "config/section_reader.h"

#include <optional>

#include "config/did_you_mean.h"
#include "config/ini_text.h"
#include "config/paths.h"

namespace loopline {
namespace {

namespace fs = std::filesystem;

bool may_be_empty(ParameterKind kind) {
    return kind == ParameterKind::text || kind == ParameterKind::list || kind == ParameterKind::path ||
           kind == ParameterKind::path_list;
}

/// One section on its way into its table.
class Reader {
 public:
    Reader(const DeclaredSection& section, const DeclaredSections& all, const fs::path& ini_folder,
           std::vector<Problem>& problems)
        : section_(section), all_(all), ini_folder_(ini_folder), problems_(problems) {}

    void read(const IniEntry& entry) {
        const auto& table = section_.table;
        const auto* parameter = table.find(entry.key);
        if (!parameter) return report(entry, "is not a key of this section" + key_hint(entry.key));
        if (entry.from_command_line && !section_.used)
            return report(entry, "would have no effect: " + table.section() +
                                     " is neither in [run] modules nor in [run] maps");
        if (entry.value.empty() && parameter->kind == ParameterKind::rows) return;  // --set world.door_m=
        if (entry.value.empty() && !may_be_empty(parameter->kind))
            return report(entry, "has no value (it is a " + kind_text(parameter->kind) + ", default " +
                                     parameter->default_text + ")");
        const auto value = resolved_value(*parameter, entry);
        if (!value) return;
        if (const auto clause = parameter->parse(*value))
            report(entry, *clause + did_you_mean(*value, parameter->choices));
    }

 private:
    void report(const IniEntry& entry, const std::string& clause) {
        problems_.emplace_back(entry.origin,
                               "[" + section_.table.section() + "] " + entry.key + " " + clause);
    }

    std::string key_hint(const std::string& key) const {
        std::vector<std::string> keys;
        for (const auto& parameter : section_.table.parameters()) keys.push_back(parameter.name);
        if (const auto near = did_you_mean(key, keys); !near.empty()) return near;
        for (const auto& [name, other] : all_)
            if (other.table.find(key)) return "; it is one of [" + name + "]";
        constexpr std::size_t most_listed = 12;
        if (keys.size() > most_listed)
            return "; `loopline describe " + section_.table.section() + "` lists its " +
                   std::to_string(keys.size()) + " keys";
        return keys.empty() ? "; it has none" : "; its keys are " + listing(keys);
    }

    /// The text to parse: that of the .ini, with paths expanded; nothing if that failed and was reported.
    std::optional<std::string> resolved_value(const Parameter& parameter, const IniEntry& entry) {
        const bool several = parameter.kind == ParameterKind::path_list;
        if (!several && parameter.kind != ParameterKind::path) return entry.value;
        auto texts = split_words(entry.list_value, ";");
        if (!several) texts.assign(1, entry.value);
        std::string joined;
        bool good = true;
        for (const auto& text : texts) {
            const auto path = resolved_path(parameter, entry, text);
            good = good && path;
            joined += (joined.empty() ? "" : ";") + path.value_or("");
        }
        return good ? std::optional(joined) : std::nullopt;
    }

    std::optional<std::string> resolved_path(const Parameter& parameter, const IniEntry& entry,
                                             const std::string& text) {
        const auto expanded = expand_path(text, entry.from_command_line ? fs::path() : ini_folder_);
        std::error_code none;
        const bool missing = section_.used && parameter.need == FileNeed::must_exist &&
                             !expanded.path.empty() && !fs::exists(expanded.path, none);
        if (!expanded.problem.empty())
            report(entry, expanded.problem);
        else if (missing)
            report(entry, "names a file that is not there: " + expanded.path);
        else
            return expanded.path;
        return std::nullopt;
    }

    const DeclaredSection& section_;
    const DeclaredSections& all_;
    const fs::path& ini_folder_;
    std::vector<Problem>& problems_;
};

}  // namespace

std::vector<std::string> names_of(const DeclaredSections& sections) {
    std::vector<std::string> names;
    for (const auto& [name, section] : sections) names.push_back(name);
    return names;
}

void read_section(const IniSection& written, const DeclaredSections& declared, const fs::path& ini_folder,
                  std::vector<Problem>& problems) {
    const auto found = declared.find(written.name);
    if (found == declared.end()) {
        const auto names = names_of(declared);
        problems.emplace_back(written.origin,
                              "there is no section [" + written.name + "]" +
                                  did_you_mean(written.name, names, "; the sections are " + listing(names)));
        return;
    }
    Reader reader(found->second, declared, ini_folder, problems);
    for (const auto& entry : written.entries) reader.read(entry);
}

}  // namespace loopline
