#include "evaluate/evaluation_reference.h"

#include "api/parameters.h"
#include "commands/command.h"
#include "evaluate/read_trajectory.h"
#include "evaluate/text_rows.h"

namespace loopline {
namespace {

/// number,odometry_x_m,odometry_y_m,estimate_x_m,estimate_y_m; a header is passed over.
std::vector<PublishedPoint> read_published_points(const std::string& file) {
    std::vector<PublishedPoint> points;
    for_each_csv_row(file, "[evaluation] published_points", [&points](const TextRow& row) {
        if (!number_from_text(row.word(0))) return;
        if (row.size() != 5)
            row.fail("a published point is number,odometry_x_m,odometry_y_m,estimate_x_m,estimate_y_m");
        points.push_back({static_cast<int>(row.number(0)),
                          {row.number(1), row.number(2)},
                          {row.number(3), row.number(4)}});
    });
    return points;
}

void read_truth(const EvaluationSettings& settings, EvaluationReference& reference) {
    const TrajectoryFile file =
        read_trajectory(settings.truth, "[evaluation] truth", Needed::positions,
                        [&reference](const StampedPose& pose) { reference.truth.push_back(pose); });
    reference.truth_has_orientation = file.has_orientation;
    reference.truth_point_m = {settings.truth_point_x_m, settings.truth_point_y_m};
    if (!file.has_orientation) {
        if (!settings.surveyed.empty())
            throw CommandError(exit_input_data, settings.truth +
                                                    " has no headings, which surveyed points need; give [evaluation] "
                                                    "truth as TUM or \"t x y phi\"");
        return;
    }
    const Pose3 T_point_base(Pose2{-settings.truth_point_x_m, -settings.truth_point_y_m, 0});
    if (!reference.truth_point_m.isZero())
        for (std::size_t i = 0; i < reference.truth.size(); ++i)
            reference.truth.set_pose(i, reference.truth[i].T_map_base * T_point_base);
    reference.truth_point_m.setZero();
}

}  // namespace

std::shared_ptr<const EvaluationReference> load_evaluation_reference(
    const EvaluationSettings& settings, const std::filesystem::path& scratch_folder) {
    if (settings.truth.empty() && settings.relations.empty()) return nullptr;
    auto reference = std::make_shared<EvaluationReference>();
    reference->truth.keep_in(scratch_folder);
    reference->truth_path = settings.truth;
    reference->relations_path = settings.relations;
    reference->scan_duration_s = settings.scan_duration_s;
    if (!settings.truth.empty()) read_truth(settings, *reference);
    if (!settings.relations.empty()) reference->relations = read_relations(settings.relations);
    if (!settings.surveyed.empty())
        reference->surveyed = read_surveyed_truth(settings.surveyed, "[evaluation] surveyed");
    if (!settings.published_points.empty())
        reference->published = read_published_points(settings.published_points);
    return reference;
}

}  // namespace loopline
