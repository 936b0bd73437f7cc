#include "config/experiment.h"

#include <algorithm>
#include <filesystem>
#include <map>

#include "config/did_you_mean.h"
#include "config/host_sections.h"
#include "config/ini_file.h"
#include "config/ini_text.h"
#include "config/paths.h"
#include "config/plugin_loader.h"
#include "config/problems.h"

namespace loopline {
namespace {

namespace fs = std::filesystem;

/// Every section that there could be, with the object that its values are bound to.
struct Section {
    Configurable::Ptr owner;  ///< null for the host's own
    ParameterTable table;
    bool used = false;
};

class Loader {
 public:
    Loader(const std::string& path, const std::vector<std::string>& overrides) : file_(read_ini_file(path)) {
        if (file_.sections.empty() && !file_.problems.empty()) throw ConfigurationError(file_.problems);
        for (const auto& assignment : overrides) apply_override(file_, assignment);
        problems_ = file_.problems;
        experiment_.config_path = path;
    }

    Experiment load(const std::vector<std::string>& rawlogs) {
        declare_host_sections();
        if (!rawlogs.empty()) forget_entry("run", "rawlog");
        read_section("run");
        if (!rawlogs.empty()) experiment_.run.rawlogs = rawlogs;
        check_rawlogs(!rawlogs.empty());
        make_chain();
        for (const auto& section : file_.sections)
            if (section.name != "run") read_section(section.name);
        check_combinations();
        if (!problems_.empty()) throw ConfigurationError(problems_);
        write_effective_ini();
        return std::move(experiment_);
    }

 private:
    void report(const Origin& origin, const std::string& sentence, ExitCode code = exit_configuration) {
        problems_.emplace_back(origin, sentence, code);
    }

    /// Where a complaint about a key that may not be there points to.
    Origin origin_of(const std::string& section_name, const std::string& key = {}) {
        auto* section = file_.find(section_name);
        if (!section) return {file_.path + ":1", 1};
        const auto* entry = section->find(key);
        return entry ? entry->origin : section->origin;
    }

    /// Whether a list has an element, be it a wrong one that was reported.
    bool names_any(const std::string& section_name, const std::string& key) {
        auto* section = file_.find(section_name);
        const auto* entry = section ? section->find(key) : nullptr;
        return entry && !split_words(entry->list_value, "; ").empty();
    }

    void forget_entry(const std::string& section_name, const std::string& key) {
        if (auto* section = file_.find(section_name))
            section->entries.erase(std::remove_if(section->entries.begin(), section->entries.end(),
                                                  [&](const IniEntry& e) { return e.key == key; }),
                                   section->entries.end());
    }

    void declare_host_sections() {
        for (auto& table : {run_table(experiment_.run), outputs_table(experiment_.outputs),
                            evaluation_table(experiment_.evaluation)}) {
            order_.push_back(table.section());
            sections_.emplace(table.section(), Section{nullptr, table, true});
        }
        for (const auto& name : known_modules()) declare(make_module(name));
        for (const auto& name : known_map_builders()) declare(make_map_builder(name));
    }

    void declare(const Configurable::Ptr& owner) {
        const auto table = owner->parameters();
        sections_.emplace(owner->info().name, Section{owner, table, false});
    }

    std::vector<std::string> section_names() const {
        std::vector<std::string> names;
        for (const auto& [name, section] : sections_) names.push_back(name);
        return names;
    }

    void read_section(const std::string& name) {
        const auto* written = file_.find(name);
        if (!written) return;
        const auto declared = sections_.find(name);
        if (declared == sections_.end())
            return report(
                written->origin,
                "there is no section [" + name + "]" +
                    did_you_mean(name, section_names(), "; the sections are " + listing(section_names())));
        for (const auto& entry : written->entries) read_entry(declared->second, entry);
    }

    void read_entry(const Section& section, const IniEntry& entry) {
        const std::string name = "[" + section.table.section() + "] " + entry.key + " ";
        const auto* parameter = section.table.find(entry.key);
        if (!parameter)
            return report(entry.origin,
                          name + "is not a key of this section" + key_hint(section.table, entry.key));
        if (entry.from_command_line && !section.used)
            return report(entry.origin, name + "would have no effect: " + section.table.section() +
                                            " is neither in [run] modules nor in [run] maps");
        const bool may_be_empty =
            parameter->kind == ParameterKind::text || parameter->kind == ParameterKind::list ||
            parameter->kind == ParameterKind::path || parameter->kind == ParameterKind::path_list;
        if (entry.value.empty() && !may_be_empty)
            return report(entry.origin, name + "has no value (it is a " + kind_text(parameter->kind) +
                                            ", default " + parameter->default_text + ")");
        const auto value = resolved_value(*parameter, entry, section.used, name);
        if (!value) return;
        if (const auto clause = parameter->parse(*value))
            report(entry.origin, name + *clause + did_you_mean(*value, parameter->choices));
    }

    std::string key_hint(const ParameterTable& table, const std::string& key) const {
        std::vector<std::string> keys;
        for (const auto& parameter : table.parameters()) keys.push_back(parameter.name);
        if (const auto near = did_you_mean(key, keys); !near.empty()) return near;
        for (const auto& [name, other] : sections_)
            if (other.table.find(key)) return "; it is one of [" + name + "]";
        return keys.empty() ? "; it has none" : "; its keys are " + listing(keys);
    }

    /// The text to parse: that of the .ini, with paths expanded; nothing if that failed and was reported.
    std::optional<std::string> resolved_value(const Parameter& parameter, const IniEntry& entry, bool used,
                                              const std::string& name) {
        const bool several = parameter.kind == ParameterKind::path_list;
        if (!several && parameter.kind != ParameterKind::path) return entry.value;
        auto texts = split_words(entry.list_value, ";");
        if (!several) texts.assign(1, entry.value);
        const fs::path base = entry.from_command_line ? fs::path() : fs::path(file_.path).parent_path();
        std::string joined;
        bool good = true;
        for (const auto& text : texts) {
            const auto expanded = expand_path(text, base);
            std::error_code none;
            const bool missing = used && parameter.need == FileNeed::must_exist && !expanded.path.empty() &&
                                 !fs::exists(expanded.path, none);
            if (!expanded.problem.empty())
                report(entry.origin, name + expanded.problem);
            else if (missing)
                report(entry.origin, name + "names a file that is not there: " + expanded.path);
            good = good && expanded.problem.empty() && !missing;
            joined += (joined.empty() ? "" : ";") + expanded.path;
        }
        return good ? std::optional(joined) : std::nullopt;
    }

    void check_rawlogs(bool from_command_line) {
        auto& rawlogs = experiment_.run.rawlogs;
        const Origin origin = origin_of("run", "rawlog");
        if (rawlogs.empty() && !names_any("run", "rawlog"))
            report(origin, "[run] rawlog names no log; name one there, or with --rawlog");
        for (auto& rawlog : rawlogs) {
            if (from_command_line) rawlog = fs::absolute(rawlog).lexically_normal().string();
            std::error_code none;
            const Origin place = from_command_line ? Origin{"--rawlog " + rawlog, 0} : origin;
            const std::string name = from_command_line ? "this " : "[run] rawlog ";
            if (!fs::exists(rawlog, none))
                report(place, name + "names a log that is not there: " + rawlog, exit_input_data);
            else if (fs::is_directory(rawlog, none))
                report(place, name + "names a folder, not a log: " + rawlog, exit_input_data);
        }
    }

    void make_chain() {
        take_named(experiment_.run.modules, "modules", "map builder", "maps", experiment_.modules);
        take_named(experiment_.run.maps, "maps", "module", "modules", experiment_.map_builders);
        const auto& chain = experiment_.run.modules;
        const Origin place = origin_of("run", "modules");
        if (chain.empty())
            report(place, "[run] modules names no module; known are " + listing(known_modules()));
        const std::string& path_of = experiment_.run.trajectory;
        if (!path_of.empty() && std::find(chain.begin(), chain.end(), path_of) == chain.end())
            report(origin_of("run", "trajectory"), "[run] trajectory names \"" + path_of +
                                                       "\", which is not in [run] modules" +
                                                       did_you_mean(path_of, chain));
    }

    /// Marks the sections of `names` as used, and hands over the objects that they are bound to.
    template <class Kind>
    void take_named(const std::vector<std::string>& names, const std::string& key,
                    const std::string& other_kind, const std::string& other_key,
                    std::vector<std::shared_ptr<Kind>>& taken) {
        const Origin place = origin_of("run", key);
        const std::string subject = "[run] " + key + " names ";
        for (const auto& name : names) {
            const auto found = sections_.find(name);
            const bool known = found != sections_.end() && found->second.owner;
            const auto object = known ? std::dynamic_pointer_cast<Kind>(found->second.owner) : nullptr;
            if (known && !object) {
                report(place, subject + "\"" + name + "\", which is a " + other_kind +
                                  "; it belongs in [run] " + other_key);
            } else if (!object) {
                const auto all = names_of<Kind>();
                report(place, subject + "\"" + name + "\", which no plugin has" +
                                  did_you_mean(name, all, "; known are " + listing(all)));
            } else if (found->second.used) {
                report(place,
                       subject + "\"" + name + "\" twice; each has one section, so it can stand there once");
            } else {
                found->second.used = true;
                order_.push_back(name);
                taken.push_back(object);
            }
        }
    }

    template <class Kind>
    std::vector<std::string> names_of() const {
        std::vector<std::string> names;
        for (const auto& [name, section] : sections_)
            if (std::dynamic_pointer_cast<Kind>(section.owner)) names.push_back(name);
        return names;
    }

    /// What each module has to say on its values together; only where each value is good by itself.
    void check_combinations() {
        if (!problems_.empty()) return;
        for (const auto& name : order_) {
            const auto& owner = sections_.at(name).owner;
            const std::string sentence = owner ? owner->check() : std::string();
            if (!sentence.empty())
                report(file_.find(name) ? origin_of(name) : origin_of("run"), "[" + name + "] " + sentence);
        }
    }

    void write_effective_ini() {
        std::string& text = experiment_.effective_ini;
        text = "# Effective configuration of loopline " LOOPLINE_VERSION
               ": every key with the value that counts.\n";
        for (const auto& name : order_) text += "\n" + ini_section_text(sections_.at(name).table);
    }

    IniFile file_;
    Experiment experiment_;
    std::vector<Problem> problems_;
    std::map<std::string, Section> sections_;
    std::vector<std::string> order_;  ///< of the sections in use
};

}  // namespace

Experiment load_experiment(const std::string& config_path, const std::vector<std::string>& overrides,
                           const std::vector<std::string>& rawlogs) {
    load_plugins();
    return Loader(config_path, overrides).load(rawlogs);
}

MapBuilder::Ptr fresh_map_builder(const MapBuilder& pattern) {
    auto fresh = std::dynamic_pointer_cast<MapBuilder>(pattern.GetRuntimeClass()->createObject());
    // parameters() binds, it changes nothing: printing through it reads the pattern's values.
    const auto values = const_cast<MapBuilder&>(pattern).parameters();
    const auto bound = fresh->parameters();
    for (const auto& parameter : bound.parameters()) parameter.parse(values.find(parameter.name)->print());
    fresh->check();
    return fresh;
}

}  // namespace loopline
