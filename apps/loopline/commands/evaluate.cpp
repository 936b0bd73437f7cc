/// loopline evaluate: how good is a trajectory, against a reference trajectory or against relations?
#include "commands/evaluate.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <iostream>

#include "evaluate/read_trajectory.h"
#include "evaluate/report.h"

namespace loopline {
namespace {

struct Options {
    std::string estimate, reference, relations, odometry;
    bool kitti = false, json = false;
    Alignment alignment = Alignment::automatic;
    std::vector<double> reference_point_m = {0, 0};
    double max_difference_s = 0.1, max_gap_s = 2, time_offset_s = 0;
    int rpe_poses = 0;
    double rpe_time_s = 0, rpe_distance_m = 0;
};

RelativeStep rpe_step(const Options& options) {
    if (options.rpe_time_s > 0) return {RelativeStep::Unit::seconds, options.rpe_time_s};
    if (options.rpe_distance_m > 0) return {RelativeStep::Unit::metres, options.rpe_distance_m};
    return {RelativeStep::Unit::poses, options.rpe_poses > 0 ? static_cast<double>(options.rpe_poses) : 1.0};
}

std::string rpe_step_text(const RelativeStep& step) {
    char text[40];
    const char* unit = step.unit == RelativeStep::Unit::seconds  ? "s"
                       : step.unit == RelativeStep::Unit::metres ? "m"
                                                                 : "pose(s)";
    std::snprintf(text, sizeof text, "%g %s", step.length, unit);
    return text;
}

std::string time_range(const std::vector<StampedPose>& poses) {
    const auto [first, last] = std::minmax_element(
        poses.begin(), poses.end(), [](const auto& a, const auto& b) { return a.stamp_ns < b.stamp_ns; });
    return seconds_text(first->stamp_ns) + " to " + seconds_text(last->stamp_ns) + " s";
}

void shift(std::vector<StampedPose>& poses, double offset_s) {
    for (auto& pose : poses) pose.stamp_ns += static_cast<StampNs>(std::llround(offset_s * 1e9));
}

/// By stamp, or by index if one of the files has none.
std::vector<PosePair> associate(const Options& options, const TrajectoryFile& estimate,
                                const TrajectoryFile& reference) {
    if (!estimate.has_stamps || !reference.has_stamps) {
        if (estimate.poses.size() != reference.poses.size())
            throw CommandError(exit_input_data,
                               options.estimate + " has " + std::to_string(estimate.poses.size()) +
                                   " poses, " + options.reference + " has " +
                                   std::to_string(reference.poses.size()) +
                                   ": KITTI poses have no time, so both files need the same number of rows");
        return associate_by_index(estimate.poses, reference.poses);
    }
    const auto match = reference.has_orientation ? associate_by_stamp : associate_positions;
    auto pairs = match(estimate.poses, reference.poses, options.max_difference_s);
    if (pairs.empty())
        throw CommandError(exit_input_data,
                           "no pose of " + options.estimate + " (" + time_range(estimate.poses) +
                               ") is within " +
                               rpe_step_text({RelativeStep::Unit::seconds, options.max_difference_s}) +
                               " of one of " + options.reference + " (" + time_range(reference.poses) +
                               "); see --max-difference-s and --time-offset-s");
    return pairs;
}

void compare_with_reference(const Options& options, const TrajectoryFile& estimate,
                            EvaluationReport& report) {
    const TrajectoryFile reference = read_trajectory(options.reference, "the reference", Needed::positions);
    TrajectoryFile compared = estimate;
    compared.poses =
        way_of_point(std::move(compared.poses), {options.reference_point_m[0], options.reference_point_m[1]});
    const auto pairs = associate(options, compared, reference);
    report.poses_reference = reference.poses.size();
    report.poses_matched = pairs.size();
    report.way_m = reference_way_m(pairs).back();
    report.absolute = absolute_error(pairs, options.alignment);
    if (reference.has_orientation) report.relative = relative_error(pairs, rpe_step(options));
    if (!options.kitti) return;
    if (!reference.has_orientation)
        throw CommandError(exit_input_data,
                           "--kitti needs orientations, and " + options.reference + " has positions alone");
    report.kitti = kitti_error(pairs);
    if (report.kitti->segments.empty()) {
        char way[40];
        std::snprintf(way, sizeof way, "%.1f", report.way_m);
        throw CommandError(exit_input_data, "--kitti needs a path longer than 100 m, " + options.reference +
                                                " is " + way + " m long where the two match");
    }
}

void compare_with_relations(const Options& options, const TrajectoryFile& estimate,
                            EvaluationReport& report) {
    if (!estimate.has_stamps)
        throw CommandError(
            exit_input_data,
            options.estimate + " has no times, which --relations needs; give it in TUM format");
    const auto relations = read_relations(options.relations);
    std::vector<StampedPose> odometry;
    if (!options.odometry.empty()) odometry = read_trajectory(options.odometry, "the odometry").poses;
    shift(odometry, options.time_offset_s);
    report.relations = relations_error(relations, estimate.poses, odometry, {options.max_gap_s});
    if (report.relations->translation_m.count > 0) return;
    throw CommandError(exit_input_data, "none of the " + std::to_string(relations.size()) + " relations of " +
                                            options.relations + " lies within the time of " +
                                            options.estimate + " (" + time_range(estimate.poses) +
                                            "); see --time-offset-s");
}

class EvaluateCommand : public Command {
 public:
    std::string name() const override { return "evaluate"; }
    std::string sentence() const override {
        return "ATE, RPE, KITTI segments and the relations metric of a trajectory, as a table or JSON";
    }

    void declare(CLI::App& app) override {
        app.add_option("--estimate", options_.estimate, "Trajectory: TUM, \"t x y theta\" or KITTI poses")
            ->required()
            ->type_name("FILE");
        app.add_option("--reference", options_.reference,
                       "What it is compared with, in any of the same formats, or positions \"t x y\"")
            ->type_name("FILE");
        app.add_option("--reference-point", options_.reference_point_m,
                       "Where on the vehicle the reference was taken: X ahead and Y left of base, in m [0 0]")
            ->expected(2)
            ->type_name("X Y")
            ->needs(app.get_option("--reference"));
        app.add_option("--relations", options_.relations,
                       "Relations \"t1 t2 x y z roll pitch yaw\" (Kuemmerle et al. 2009)")
            ->type_name("FILE");
        app.add_option("--odometry", options_.odometry,
                       "Dense odometry that carries a pose to a relation's time")
            ->type_name("FILE")
            ->needs(app.get_option("--relations"));
        app.add_flag("--kitti", options_.kitti, "Also KITTI's errors over segments of 100 to 800 m")
            ->needs(app.get_option("--reference"));
        app.add_option("--align", options_.alignment, "Before the ATE: auto, 2d, 3d or none")
            ->transform(
                CLI::CheckedTransformer(std::map<std::string, Alignment>{{"auto", Alignment::automatic},
                                                                         {"2d", Alignment::planar},
                                                                         {"3d", Alignment::spatial},
                                                                         {"none", Alignment::none}}))
            ->option_text("auto|2d|3d|none");
        app.add_option("--max-difference-s", options_.max_difference_s,
                       "Poses farther apart in time than this are not matched [0.1]")
            ->check(CLI::NonNegativeNumber);
        auto* poses = app.add_option("--rpe-poses", options_.rpe_poses, "Step of the RPE in poses [1]")
                          ->check(CLI::PositiveNumber);
        auto* time = app.add_option("--rpe-time-s", options_.rpe_time_s, "Step of the RPE in seconds")
                         ->check(CLI::PositiveNumber);
        auto* way = app.add_option("--rpe-distance-m", options_.rpe_distance_m,
                                   "Step of the RPE in metres along the reference")
                        ->check(CLI::PositiveNumber);
        poses->excludes(time)->excludes(way);
        time->excludes(way);
        app.add_option("--max-gap-s", options_.max_gap_s,
                       "A relation farther than this from both neighbour poses is not used [2]")
            ->check(CLI::NonNegativeNumber);
        app.add_option("--time-offset-s", options_.time_offset_s,
                       "Added to the stamps of the estimate and the odometry [0]");
        app.add_flag("--json", options_.json, "Flat JSON keys instead of a table");
    }

    ExitCode run() override {
        if (options_.reference.empty() && options_.relations.empty())
            throw CommandError(exit_configuration,
                               "evaluate needs --reference FILE, --relations FILE or both");
        TrajectoryFile estimate = read_trajectory(options_.estimate, "the estimate");
        shift(estimate.poses, options_.time_offset_s);
        EvaluationReport report;
        report.poses_estimate = estimate.poses.size();
        if (!options_.reference.empty()) compare_with_reference(options_, estimate, report);
        if (!options_.relations.empty()) compare_with_relations(options_, estimate, report);
        std::cout << (options_.json ? report_json(report)
                                    : report_text(report, rpe_step_text(rpe_step(options_))));
        return exit_done;
    }

 private:
    Options options_;
};

}  // namespace

std::unique_ptr<Command> make_evaluate_command() {
    return std::make_unique<EvaluateCommand>();
}

}  // namespace loopline
