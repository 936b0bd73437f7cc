#include "pipeline/loop_rejection.h"

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "api/loop_closer.h"
#include "commands/command.h"
#include "pipeline/kept_states.h"

namespace loopline {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Where an experiment says which loops are refused.
struct RefusalsKey {
    const LoopCloser* closer = nullptr;
    std::string section, key;

    std::string assignment(const std::string& value) const { return section + "." + key + "=" + value; }
};

RefusalsKey refusals_key_of(const Experiment& experiment) {
    for (const auto& module : experiment.modules)
        if (const auto* closer = dynamic_cast<const LoopCloser*>(module.get()))
            return {closer, module->info().name, closer->refusals_key()};
    return {};
}

/// An effective configuration without its refusals, and these.
struct SplitIni {
    std::string rest, refusals;
};

SplitIni split(const std::string& ini, const RefusalsKey& key) {
    SplitIni result;
    std::istringstream lines(ini);
    const std::string assignment = key.key + " =";
    std::string section;
    for (std::string line; std::getline(lines, line);) {
        if (!line.empty() && line[0] == '[') section = line.substr(1, line.find(']') - 1);
        if (section == key.section && line.rfind(assignment, 0) == 0) {
            const auto value = split_words(line.substr(assignment.size()), "\n");
            result.refusals = value.empty() ? "" : value.front();
            line = assignment;
        }
        result.rest += line + "\n";
    }
    return result;
}

bool holds_all(const std::string& refusals, const std::string& of) {
    const auto have = split_words(refusals, ",");
    const auto wanted = split_words(of, ",");
    return std::all_of(wanted.begin(), wanted.end(), [&have](const std::string& item) {
        return std::find(have.begin(), have.end(), item) != have.end();
    });
}

std::string text_of(const fs::path& file) {
    std::ifstream stream(file, std::ios::binary);
    std::ostringstream text;
    text << stream.rdbuf();
    return text.str();
}

json json_of(const fs::path& file) {
    constexpr bool with_exceptions = false;
    return json::parse(text_of(file), nullptr, with_exceptions);
}

[[noreturn]] void refuse(const std::string& sentence) {
    throw CommandError(exit_configuration, "--reject-loop: " + sentence);
}

/// A run in a folder, of which loops are rejected.
class FinishedRun {
 public:
    explicit FinishedRun(fs::path folder)
        : folder_(std::move(folder)),
          ini_(text_of(folder_ / "config.ini")),
          metrics_(json_of(folder_ / "metrics.json")),
          manifest_(json_of(folder_ / "manifest.json")) {
        if (ini_.empty() || !metrics_.is_object() || !manifest_.is_object())
            refuse("there is no run in " + folder_.string() +
                   " whose loops could be rejected; run it first without --reject-loop");
    }

    /// Its refusals, those of the .ini among them.
    std::string refusals(const Experiment& experiment, const RefusalsKey& key) const {
        const SplitIni then = split(ini_, key), now = split(experiment.effective_ini, key);
        if (then.rest != now.rest)
            refuse("the run in " + folder_.string() + " was made with another configuration (" +
                   first_difference(then.rest, now.rest) +
                   "); run without --reject-loop to start from the beginning");
        if (!holds_all(then.refusals, now.refusals))
            refuse("the run in " + folder_.string() + " was made with another configuration ([" +
                   key.section + "] " + key.key + " = " + then.refusals + ", and now " + now.refusals +
                   "); run without --reject-loop to start from the beginning");
        return then.refusals;
    }

    void check_logs(const std::vector<std::string>& rawlogs, const std::vector<LogIdentity>& logs) const {
        const json inputs = manifest_.value("inputs", json::array());
        for (std::size_t i = 0; i < logs.size(); ++i)
            if (i >= inputs.size() || inputs[i].value("sha256", "") != logs[i].sha256)
                refuse("the run in " + folder_.string() + " was made with another log than what " +
                       rawlogs[i] + " holds now; run without --reject-loop to start from the beginning");
    }

    /// The name of an accepted loop.
    std::string loop(std::uint64_t number) const {
        const json loops = metrics_.value("loops", json::array());
        const std::string file = (folder_ / "metrics.json").string();
        if (number < 1 || number > loops.size())
            refuse("there is no loop " + std::to_string(number) + ": " + file + " lists " +
                   (loops.empty() ? "none" : "numbers 1 to " + std::to_string(loops.size())));
        const json& loop = loops[number - 1];
        if (loop.value("decision", "") != "accepted")
            refuse("loop " + std::to_string(number) + " of " + file + " is not an accepted one (" +
                   loop.value("reason", "") + "), so there is nothing to reject");
        const std::string name = loop.value("loop", "");
        if (name.empty()) refuse(file + " was written by another version of the program; run it again first");
        return name;
    }

 private:
    fs::path folder_;
    std::string ini_;
    json metrics_, manifest_;
};

}  // namespace

RejectedRun reject_loops(const fs::path& folder, const std::vector<std::uint64_t>& numbers,
                         const ExperimentLoader& load) {
    RejectedRun rejected{load({}), nullptr};
    RefusalsKey key = refusals_key_of(rejected.experiment);
    if (key.closer == nullptr) refuse("no module of [run] modules closes loops");
    const FinishedRun run(folder);
    std::string refusals = run.refusals(rejected.experiment, key);
    std::vector<std::uint64_t> ordered = numbers;
    std::sort(ordered.begin(), ordered.end());
    ordered.erase(std::unique(ordered.begin(), ordered.end()), ordered.end());
    for (const std::uint64_t number : ordered) refusals += (refusals.empty() ? "" : ", ") + run.loop(number);
    const auto logs = identities_of(rejected.experiment.run.rawlogs);
    run.check_logs(rejected.experiment.run.rawlogs, logs);

    rejected.experiment = load({key.assignment(refusals)});
    key = refusals_key_of(rejected.experiment);
    const SplitIni now = split(rejected.experiment.effective_ini, key);
    const auto serves = [&](const CheckpointHead& head) {
        const SplitIni then = split(head.effective_ini, key);
        return then.rest == now.rest && head.loop > 0 &&
               std::equal(logs.begin(), logs.end(), head.logs.begin(), head.logs.end(),
                          [](const LogIdentity& a, const LogIdentity& b) { return a.sha256 == b.sha256; }) &&
               key.closer->refuse_alike_before(then.refusals, now.refusals, head.loop_ns);
    };
    for (std::uint64_t loop = ordered.front(); loop > 0 && !rejected.checkpoint; --loop)
        rejected.checkpoint = Checkpoint::kept(folder / kept_state_name(loop), serves);
    return rejected;
}

Experiment with_rejections_of_checkpoint(const fs::path& folder, Experiment experiment,
                                         const ExperimentLoader& load) {
    const RefusalsKey key = refusals_key_of(experiment);
    if (key.closer == nullptr) return experiment;
    std::string ini;
    Checkpoint::kept(checkpoint_in(folder), [&ini](const CheckpointHead& head) {
        ini = head.effective_ini;
        return false;
    });
    const SplitIni then = split(ini, key), now = split(experiment.effective_ini, key);
    const bool further =
        then.rest == now.rest && then.refusals != now.refusals && holds_all(then.refusals, now.refusals);
    return further ? load({key.assignment(then.refusals)}) : std::move(experiment);
}

}  // namespace loopline
