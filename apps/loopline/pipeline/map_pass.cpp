#include "pipeline/map_pass.h"

#include <algorithm>

#include "api/map_maker.h"
#include "pipeline/interest.h"
#include "pipeline/log_source.h"
#include "pipeline/progress.h"
#include "pipeline/run_scratch.h"
#include "pipeline/stopwatch.h"

namespace loopline {
namespace {

struct Drawing {
    MapBuilder::Ptr builder;
    const Trajectory* trajectory;
    Results* results;
    int index;             ///< in [run] maps
    ModuleTiming* timing;  ///< null where nobody asks
    Interest interest;
};

std::vector<Drawing> drawings_of(const RunSetup& setup, RunRecord& record) {
    const auto& experiment = setup.experiment;
    std::vector<Drawing> drawings;
    const bool wanted = experiment.outputs.maps || experiment.outputs.snapshots || experiment.outputs.report;
    if (!wanted || record.trajectory == nullptr || record.trajectory->empty()) return drawings;
    const bool has_odometry = record.odometry != nullptr && !record.odometry->empty();
    for (std::size_t i = 0; i < experiment.map_builders.size(); ++i) {
        const auto& builder = experiment.map_builders[i];
        const std::string name = builder->info().name;
        if (auto sentence = undrawn_map(builder->info(), record.facts); !sentence.empty()) {
            record.warnings.push_back(std::move(sentence));
            continue;
        }
        const int index = static_cast<int>(i);
        const Interest interest(builder->info());
        drawings.push_back(
            {builder, record.trajectory, &record.results, index, &record.modules[name], interest});
        if (has_odometry && builder->wants_dead_reckoning())
            drawings.push_back({fresh_map_builder(*builder), record.odometry, &record.odometry_results, index,
                                nullptr, interest});
    }
    return drawings;
}

void insert(Drawing& drawing, const StreamItem& item) {
    const Interest::Kind interest = drawing.interest.in(*item.observation);
    if (interest == Interest::Kind::none) return;
    const auto start = Clock::now();
    drawing.builder->insert(item);
    if (drawing.timing == nullptr) return;
    const double elapsed_ms = milliseconds_since(start);
    drawing.timing->calls += interest == Interest::Kind::main ? 1 : 0;
    drawing.timing->total_ms += elapsed_ms;
    drawing.timing->worst_ms = std::max(drawing.timing->worst_ms, elapsed_ms);
}

}  // namespace

void map_pass(const RunSetup& setup, const Attempt& attempt, std::uint64_t items, RunRecord& record) {
    auto drawings = drawings_of(setup, record);
    if (drawings.empty() || attempt.without_maps) return;
    WorkerState* state = attempt.rules.state;
    const auto at_work = [state](const Drawing& drawing, std::uint64_t position) {
        if (state != nullptr) state->enter(WorkerState::Stage::map_builder, drawing.index, position);
    };
    LogSource source(setup.experiment.run.rawlogs, attempt.rules, Mounting(setup.experiment.mount));
    Progress progress("drawing maps", !setup.quiet);
    RunContext context;
    context.threads = setup.threads;
    context.seed = setup.experiment.run.seed;
    context.scratch_folder = scratch_folder_of(setup);
    if (!setup.experiment.outputs.maps)
        for (const auto& drawing : drawings)
            if (auto* maker = dynamic_cast<MapMaker*>(drawing.builder.get())) maker->leave_out_map();
    for (const auto& drawing : drawings) drawing.builder->start(context, *drawing.trajectory);
    for (StreamItem item; source.next(item) && item.sequence < items;) {
        for (auto& drawing : drawings) {
            at_work(drawing, item.sequence);
            insert(drawing, item);
        }
        progress.tick(source);
    }
    for (const auto& drawing : drawings) {
        at_work(drawing, WorkerState::at_the_end);
        const auto start = Clock::now();
        drawing.builder->finish(*drawing.results);
        if (drawing.timing != nullptr) drawing.timing->finish_ms += milliseconds_since(start);
        const auto* maker = dynamic_cast<const MapMaker*>(drawing.builder.get());
        if (maker != nullptr && maker->cloud() != nullptr && !maker->cloud()->points().empty()) {
            record.cloud = maker->cloud();  // rather than that by the poses of the time
            record.cloud_on_trajectory = maker->carried_by().empty();
        }
    }
}

}  // namespace loopline
