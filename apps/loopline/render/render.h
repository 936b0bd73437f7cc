/// Off-screen pictures and the report.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "api/results.h"
#include "render/picture_size.h"
#include "render/scene_content.h"

namespace loopline {

enum class View {
    top,           ///< plan: scan points, walls, paths, occupancy grid
    axonometric,   ///< parallel projection from above and aside, walls raised
    follow,        ///< from behind the vehicle at its last pose
    before_after,  ///< scan points by dead reckoning and by the estimate, side by side at one scale
    survey_top,          ///< the survey cloud from above, by dead reckoning and by the estimate
    survey_axonometric,  ///< the same in parallel projection from aside
};

/// One picture with title, legend and scale bar, as PNG; empty content gives a picture that says so. `size`
/// must be allowed (picture_size.h). Throws CommandError if the file can't be written or a spatial view can't
/// be rendered here.
void render_picture(const SceneContent& content, View view, PictureSize size,
                    const std::filesystem::path& png);

/// The set that every run writes into `folder` (top, axonometric, before_after, and where there is a survey cloud,
/// survey_top and survey_axonometric), in a fixed order; returns the files.
std::vector<std::filesystem::path> write_snapshots(const SceneContent& content,
                                                   const std::filesystem::path& folder);

/// correction_N.png of each correction of the path, N from 1, or of those with the largest misclosures;
/// returns the files.
std::vector<std::filesystem::path> write_correction_pictures(const Results& results, StampNs first_stamp_ns,
                                                             const std::string& run_title,
                                                             const std::filesystem::path& folder);
inline constexpr std::size_t most_correction_pictures = 12;

struct RunRecord;
struct EvaluationReference;
/// earth_plan.png and earth_height.png of a run whose path is on the Earth and has one to compare with, and
/// earth_error.png if the truth's place there is known (`reference` may be null); `map` is what lies below.
/// Returns the files.
std::vector<std::filesystem::path> write_earth_pictures(const RunRecord& record,
                                                        const EvaluationReference* reference,
                                                        const SceneContent& map,
                                                        const std::filesystem::path& folder);

/// MRPT's .3Dscene of the same content.
void write_3d_scene(const SceneContent& content, const std::filesystem::path& file);

/// report.html of a finished run directory: one self-contained page made from the files in it.
void write_report(const std::filesystem::path& run_directory);

}  // namespace loopline
