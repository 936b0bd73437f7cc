#include "pipeline/estimate_pass.h"

#include <mrpt/obs/CObservation2DRangeScan.h>

#include <algorithm>
#include <memory>
#include <utility>

#include "api/loop_closer.h"
#include "api/map_maker.h"
#include "api/observation_class.h"
#include "api/set_aside.h"
#include "commands/command.h"
#include "evaluate/fix_errors.h"
#include "pipeline/checkpoints.h"
#include "pipeline/log_source.h"
#include "pipeline/module_chain.h"
#include "pipeline/progress.h"
#include "pipeline/recorder.h"
#include "pipeline/run_scratch.h"

namespace loopline {
namespace {

std::string joined(const std::vector<std::string>& parts, const char* separator) {
    std::string text;
    for (const auto& part : parts) text += (text.empty() ? "" : separator) + part;
    return text;
}

/// A sentence for each module that misses an observation class, in the log and among what the modules before
/// it publish.
std::vector<std::string> unmet_needs(const std::vector<Module::Ptr>& modules, const LogSource& source,
                                     const std::string& logs) {
    std::vector<std::string> sentences, published;
    for (const auto& module : modules) {
        const ModuleInfo info = module->info();
        for (const auto& need : info.needs) {
            const bool from_module = std::any_of(
                published.begin(), published.end(),
                [&](const std::string& name) { return short_class_name(name) == short_class_name(need); });
            if (!from_module && !source.facts().has_class(need))
                sentences.push_back(logs + ": module " + info.name + " needs " + need +
                                    ", and this log holds " + source.facts().inventory());
        }
        published.insert(published.end(), info.publishes.begin(), info.publishes.end());
    }
    return sentences;
}

/// There must be something to write; throws CommandError otherwise.
void check_log(const RunSetup& setup, const LogSource& source, bool interrupted) {
    const auto& experiment = setup.experiment;
    const std::string logs = joined(experiment.run.rawlogs, ", ");
    const auto damages = source.damages();
    if (source.facts().observations() == 0) {
        if (interrupted)
            throw CommandError(exit_interrupted, "interrupted before anything was read; nothing is saved");
        throw CommandError(exit_input_data, damages.empty() ? logs + ": this log holds no observation"
                                                            : joined(damages, "\n"));
    }
    auto problems = interrupted ? std::vector<std::string>() : unmet_needs(experiment.modules, source, logs);
    if (problems.empty()) return;
    problems.insert(problems.begin(), damages.begin(), damages.end());
    throw CommandError(exit_input_data, joined(problems, "\n"));
}

void choose_trajectories(const Experiment& experiment, RunRecord& record) {
    for (const auto& module : experiment.modules) {
        const std::string name = module->info().name;
        const Trajectory* trajectory = module->trajectory();
        if (name == "odometry") record.odometry = trajectory;
        const bool wanted = experiment.run.trajectory.empty() || name == experiment.run.trajectory;
        if (!wanted || trajectory == nullptr) continue;
        record.trajectory = trajectory;
        record.trajectory_of = name;
    }
    if (record.trajectory == nullptr && !experiment.run.trajectory.empty())
        throw CommandError(exit_configuration, experiment.config_path + ": [run] trajectory names " +
                                                   experiment.run.trajectory +
                                                   ", a module that estimates no path");
}

/// What a module says of its own path on the Earth holds for no other.
void keep_place_of_trajectory(RunRecord& record) {
    Results& results = record.results;
    if (!results.earth || results.earth_by == record.trajectory_of) return;
    results.earth.reset();
    results.uncorrected.reset();
    results.fixes = {};
}

/// Maps that nobody will see are not made.
void leave_out_maps(const RunSetup& setup) {
    if (setup.experiment.outputs.maps && !setup.calibrates) return;
    for (const auto& module : setup.experiment.modules)
        if (auto* maker = dynamic_cast<MapMaker*>(module.get())) maker->leave_out_map();
}

void choose_cloud(const Experiment& experiment, RunRecord& record) {
    for (const auto& module : experiment.modules)
        if (const auto* maker = dynamic_cast<const MapMaker*>(module.get()))
            if (const StoredCloud* cloud = maker->cloud(); cloud != nullptr && !cloud->points().empty()) {
                record.cloud = cloud;
                record.cloud_on_trajectory = maker->carried_by() == record.trajectory_of;
            }
}

void record_input(const RunSetup& setup, const LogSource& source, const std::vector<LogIdentity>& logs,
                  RunRecord& record) {
    record.warnings = source.warnings();
    for (std::size_t i = 0; i < source.inputs(); ++i) {
        const auto& reader = source.reader(i);
        record.inputs.push_back(
            {reader.path(), reader.file_bytes(), logs[i].sha256, reader.objects(), reader.damage()});
    }
    const auto paths = input_paths(setup.experiment);
    for (std::size_t i = source.inputs(); i < paths.size() && i < logs.size(); ++i)
        record.inputs.push_back({paths[i], logs[i].bytes, logs[i].sha256, 0, {}, false});
    record.facts = source.facts();
    record.scans_read = source.facts().scans();
    record.first_stamp_ns = source.facts().first_stamp_ns();
    record.last_stamp_ns = source.facts().last_stamp_ns();
    if (source.refused() > 0)
        record.results.metrics["observations_refused"] = static_cast<std::int64_t>(source.refused());
    record.config_path = setup.experiment.config_path;
    record.effective_ini = setup.experiment.effective_ini;
    record.seed = setup.experiment.run.seed;
}

/// Null if the truth has no feature points.
std::unique_ptr<FeaturePointHits> watched_points(const RunSetup& setup) {
    const auto& reference = setup.reference;
    if (!reference || reference->surveyed.points.empty() || reference->truth.empty()) return nullptr;
    return std::make_unique<FeaturePointHits>(reference->surveyed.points, TruePath(truth_of(reference)),
                                              reference->scan_duration_s);
}

/// How many of the scans, which are in the log's order as the poses are, have a pose.
std::uint64_t poses_among(const SetAside<std::uint64_t>& scan_sequences, const Trajectory& trajectory) {
    std::uint64_t count = 0;
    std::size_t scan = 0;
    for (const TrajectoryEntry& entry : trajectory.entries()) {
        while (scan < scan_sequences.size() && scan_sequences[scan] < entry.sequence) ++scan;
        if (scan < scan_sequences.size() && scan_sequences[scan] == entry.sequence) ++count;
    }
    return count;
}

/// How the run ended: what the user did counts first, then the log, then the estimate.
void set_status(RunRecord& record, bool interrupted, bool damaged) {
    const auto set = [&record](const char* status, ExitCode code) {
        record.status = status;
        record.exit_code = code;
    };
    if (interrupted)
        set("interrupted", exit_interrupted);
    else if (damaged)
        set("damaged_input", exit_input_data);
    else if (record.results.refused)
        set("refused", exit_refused);
    else
        set("done", exit_done);
}

}  // namespace

std::uint64_t estimate_pass(const RunSetup& setup, const Attempt& attempt, RunRecord& record) {
    const auto& experiment = setup.experiment;
    const auto scratch_folder = scratch_folder_of(setup);
    LogSource source(experiment.run.rawlogs, attempt.rules, Mounting(experiment.mount));
    Recorder recorder(setup.folder, experiment.outputs.record);
    ModuleChain::Listener record_published;
    if (!experiment.outputs.record.empty())
        record_published = [&recorder](const StreamItem& item) { recorder.take(*item.observation); };
    ModuleChain chain(experiment.modules, attempt.rules.state, std::move(record_published));
    Progress progress("estimating", !setup.quiet);
    leave_out_maps(setup);
    chain.start({setup.threads, experiment.run.seed, setup.calibrates, scratch_folder});
    Checkpoints checkpoints(setup, attempt, chain, recorder);

    const auto stop_requested = [&] {
        return attempt.rules.state != nullptr && attempt.rules.state->stop_requested;
    };
    const auto points = watched_points(setup);
    const auto fix_errors = FixErrors::against(setup.reference);
    SetAside<std::uint64_t> scan_sequences;
    scan_sequences.keep_unseen_in(scratch_folder);
    std::uint64_t items = 0;
    bool interrupted = false;
    for (StreamItem item; source.next(item); ++items) {
        interrupted = stop_requested();
        if (interrupted || (attempt.stop_before_sequence && item.sequence >= *attempt.stop_before_sequence))
            break;
        if (source.facts().latest_is_scan()) scan_sequences.push_back(item.sequence);
        if (points)
            if (const auto* scan = as<mrpt::obs::CObservation2DRangeScan>(item.observation.get()))
                points->take(*scan, item.stamp_ns, item.sequence);
        if (fix_errors)
            if (const auto* gps = as<mrpt::obs::CObservationGPS>(item.observation.get()))
                fix_errors->take(*gps, item.stamp_ns);
        progress.tick(source);
        if (items < checkpoints.resumed_at()) continue;
        chain.process(std::move(item));
        checkpoints.after_item(items + 1);
    }
    progress.clear();
    if (items < checkpoints.resumed_at())
        throw CommandError(
            exit_interrupted,
            "interrupted before the log was read up to the checkpoint; nothing has changed, and "
            "--resume goes on from there");
    try {
        check_log(setup, source, interrupted);
    } catch (const CommandError&) {
        checkpoints.discard();
        throw;
    }
    if (interrupted) record.can_resume = checkpoints.write(items);
    chain.finish(record.results);
    if (fix_errors) record.results.metrics.merge(fix_errors->metrics());

    choose_trajectories(experiment, record);
    keep_place_of_trajectory(record);
    choose_cloud(experiment, record);
    record_input(setup, source, checkpoints.logs(), record);
    record.earlier_wall_s = checkpoints.earlier_wall_s();
    record.earlier_cpu_s = checkpoints.earlier_cpu_s();
    for (auto& sentence : recorder.commit()) record.warnings.push_back(std::move(sentence));
    for (const auto& sentence : checkpoints.warnings()) record.warnings.push_back(sentence);
    for (const auto& module : experiment.modules)
        if (const auto* closer = dynamic_cast<const LoopCloser*>(module.get()))
            for (auto& sentence : closer->loop_warnings()) record.warnings.push_back(std::move(sentence));
    for (const KeptState& state : checkpoints.kept_states())
        record.states.push_back(kept_state_name(state.loop));
    if (!setup.calibrates) remove_other_states(setup.folder, checkpoints.kept_states());
    for (const auto& sentence : record.results.warnings) record.warnings.push_back(sentence);
    if (!attempt.failure.empty()) record.results.refused = attempt.failure;
    if (points && record.trajectory != nullptr)
        record.feature_points = points->estimates(*record.trajectory, record.odometry);
    if (setup.reference) record.published_points = setup.reference->published;
    if (record.trajectory != nullptr) record.scans_used = poses_among(scan_sequences, *record.trajectory);
    const auto timings = chain.timings();
    for (std::size_t i = 0; i < experiment.modules.size(); ++i)
        record.modules[experiment.modules[i]->info().name] = timings[i];
    set_status(record, interrupted, !source.damages().empty());
    return items;
}

}  // namespace loopline
