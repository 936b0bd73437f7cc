#include "pipeline/run_outputs.h"

#include "commands/command.h"
#include "evaluate/evaluate_loops.h"
#include "output/run_directory.h"
#include "pipeline/run_scratch.h"
#include "render/render.h"
#include "render/scene_content.h"

namespace loopline {
namespace {

void enter(WorkerState* state, WorkerState::Stage stage) {
    if (state != nullptr) state->enter(stage, 0, 0);
}

void evaluate(const RunSetup& setup, RunRecord& record) {
    if (record.trajectory == nullptr) return;
    const auto add = [&record](const RunEvaluation& evaluation) {
        record.results.metrics.insert(evaluation.metrics.begin(), evaluation.metrics.end());
        record.warnings.insert(record.warnings.end(), evaluation.warnings.begin(), evaluation.warnings.end());
    };
    add(evaluate_run(*record.trajectory, setup.reference, scratch_folder_of(setup), record.results.earth));
    add(evaluate_loops(record.results.loops, *record.trajectory, setup.reference));
    add(evaluate_points(record.feature_points.points, record.feature_points.missed));
    if (setup.reference)
        add(evaluate_surveys(record.results, record.odometry_results, *record.trajectory, record.odometry,
                             *setup.reference));
}

void make_folder(const std::filesystem::path& folder) {
    std::error_code problem;
    std::filesystem::create_directories(folder, problem);
    if (problem)
        throw CommandError(exit_configuration,
                           folder.string() + ": this folder can't be made (" + problem.message() + ")");
}

std::vector<std::string> relative_to(const std::filesystem::path& folder,
                                     const std::vector<std::filesystem::path>& files) {
    std::vector<std::string> names;
    for (const auto& file : files) names.push_back(file.lexically_relative(folder).string());
    return names;
}

void draw(const RunSetup& setup, const RunRecord& record) {
    const auto& outputs = setup.experiment.outputs;
    if (!outputs.snapshots) return;
    const std::string title = std::filesystem::path(record.config_path).stem().string();
    const SceneContent content = scene_from_record(record, title);
    add_to_manifest(setup.folder,
                    relative_to(setup.folder, write_snapshots(content, setup.folder / "snapshots")));
    add_to_manifest(setup.folder,
                    relative_to(setup.folder, write_correction_pictures(record.results, record.first_stamp_ns,
                                                                        title, setup.folder / "snapshots")));
    add_to_manifest(setup.folder,
                    relative_to(setup.folder, write_earth_pictures(record, setup.reference.get(), content,
                                                                   setup.folder / "snapshots")));
    if (!outputs.maps) return;
    write_3d_scene(content, setup.folder / "map.3Dscene");
    add_to_manifest(setup.folder, {"map.3Dscene"});
}

}  // namespace

void write_results(const RunSetup& setup, RunRecord& record, WorkerState* state) {
    enter(state, WorkerState::Stage::writing);
    evaluate(setup, record);
    make_folder(setup.folder);
    set_cost(record, setup);
    write_run_directory(setup.folder, record, setup.experiment.outputs);
    if (std::filesystem::exists(setup.folder / "recorded.rawlog"))
        add_to_manifest(setup.folder, {"recorded.rawlog"});
    enter(state, WorkerState::Stage::idle);
}

void draw_results(const RunSetup& setup, RunRecord& record, WorkerState* state) {
    if (!setup.experiment.outputs.snapshots && !setup.experiment.outputs.report) return;
    enter(state, WorkerState::Stage::drawing);
    draw(setup, record);
    set_cost(record, setup);
    write_metrics(setup.folder, record);
    if (setup.experiment.outputs.report) {
        write_report(setup.folder);
        add_to_manifest(setup.folder, {"report.html"});
    }
    enter(state, WorkerState::Stage::idle);
}

}  // namespace loopline
