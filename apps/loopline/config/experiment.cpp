#include "config/experiment.h"

#include <algorithm>
#include <filesystem>

#include "config/did_you_mean.h"
#include "config/host_sections.h"
#include "config/ini_text.h"
#include "config/plugin_loader.h"
#include "config/section_reader.h"

namespace loopline {
namespace {

namespace fs = std::filesystem;

class Loader {
 public:
    Loader(const std::string& path, const std::vector<std::string>& overlays,
           const std::vector<std::string>& overrides)
        : file_(read_ini_file(path)) {
        if (file_.sections.empty() && !file_.problems.empty()) throw ConfigurationError(file_.problems);
        if (const auto* section = file_.find("simulation"))
            throw ConfigurationError({{section->origin,
                                       "an experiment has no section [simulation]; this is a scenario, for "
                                       "`loopline simulate`"}});
        for (const auto& overlay : overlays) apply_overlay(file_, read_ini_file(overlay));
        for (const auto& assignment : overrides) apply_override(file_, assignment);
        problems_ = file_.problems;
        experiment_.config_path = path;
    }

    Experiment load(const std::vector<std::string>& rawlogs) {
        declare_host_sections();
        if (!rawlogs.empty()) forget_entry("run", "rawlog");
        if (const auto* section = file_.find("run")) read(*section);
        if (!rawlogs.empty()) experiment_.run.rawlogs = rawlogs;
        check_rawlogs(!rawlogs.empty());
        make_chain();
        for (const auto& section : file_.sections)
            if (section.name != "run") read(section);
        find_truth();
        check_combinations();
        if (!problems_.empty()) throw ConfigurationError(problems_);
        write_effective_ini();
        return std::move(experiment_);
    }

 private:
    void report(const Origin& origin, const std::string& sentence, ExitCode code = exit_configuration) {
        problems_.emplace_back(origin, sentence, code);
    }

    void read(const IniSection& section) {
        read_section(section, sections_, fs::path(file_.path).parent_path(), problems_);
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
        for (auto& table : {run_table(experiment_.run), mount_table(experiment_.mount),
                            outputs_table(experiment_.outputs), evaluation_table(experiment_.evaluation)}) {
            order_.push_back(table.section());
            sections_.emplace(table.section(), DeclaredSection{nullptr, table, true});
        }
        for (const auto& name : known_modules()) declare(make_module(name));
        for (const auto& name : known_map_builders()) declare(make_map_builder(name));
    }

    void declare(const Configurable::Ptr& owner) {
        const auto table = owner->parameters();
        sections_.emplace(owner->info().name, DeclaredSection{owner, table, false});
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

    /// What `loopline simulate` leaves beside a log.
    void find_truth() {
        auto& evaluation = experiment_.evaluation;
        std::error_code none;
        const auto take = [&none](std::string& path, const fs::path& found) {
            if (fs::is_regular_file(found, none)) path = found.string();
        };
        const auto& rawlogs = experiment_.run.rawlogs;
        if (evaluation.truth.empty() && evaluation.truth_beside_log && !rawlogs.empty())
            take(evaluation.truth, fs::path(rawlogs.front()).replace_extension(".truth.tum"));
        const std::string end = ".truth.tum", &truth = evaluation.truth;
        if (evaluation.surveyed.empty() && truth.size() > end.size() &&
            truth.compare(truth.size() - end.size(), end.size(), end) == 0)
            take(evaluation.surveyed, fs::path(truth).replace_extension(".csv"));
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
                const auto all = names_of_kind<Kind>();
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
    std::vector<std::string> names_of_kind() const {
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
        if (!problems_.empty()) return;
        for (const auto& module : experiment_.modules) {
            const std::string name = module->info().name, sentence = module->check_input_files();
            if (!sentence.empty())
                report(file_.find(name) ? origin_of(name) : origin_of("run"), "[" + name + "] " + sentence,
                       exit_input_data);
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
    DeclaredSections sections_;
    std::vector<std::string> order_;  ///< of the sections in use
};

}  // namespace

Experiment load_experiment(const std::string& config_path, const std::vector<std::string>& overrides,
                           const std::vector<std::string>& rawlogs,
                           const std::vector<std::string>& overlays) {
    load_plugins();
    return Loader(config_path, overlays, overrides).load(rawlogs);
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
