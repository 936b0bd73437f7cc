/// Pictures of the corrections of a run: which ones, and what stands over them.
#include <algorithm>
#include <numeric>

#include "render/correction_view.h"
#include "render/picture_file.h"
#include "render/render.h"
#include "render/scale.h"

namespace loopline {
namespace {

/// In the order of the log, but only those with the largest misclosures.
std::vector<std::size_t> worth_a_picture(const std::vector<PathCorrection>& corrections) {
    const auto size_m = [&](std::size_t i) {
        const double size = misclosure_size_m(corrections[i].T_before_after);
        return std::isfinite(size) ? size : -1;
    };
    std::vector<std::size_t> chosen(corrections.size());
    std::iota(chosen.begin(), chosen.end(), 0);
    std::stable_sort(chosen.begin(), chosen.end(),
                     [&](std::size_t a, std::size_t b) { return size_m(a) > size_m(b); });
    chosen.resize(std::min<std::size_t>(chosen.size(), most_correction_pictures));
    std::sort(chosen.begin(), chosen.end());
    return chosen;
}

/// What the poses moved by at most.
double largest_move_m(const PathCorrection& correction) {
    double largest_m = 0;
    for (std::size_t i = 0; i < std::min(correction.before.size(), correction.after.size()); ++i) {
        const double moved_m =
            (correction.after[i].translation() - correction.before[i].translation()).norm();
        if (std::isfinite(moved_m)) largest_m = std::max(largest_m, moved_m);
    }
    return largest_m;
}

/// Number of the loop that a correction is for: the last one accepted until then; 0 if there is none.
std::size_t loop_of(const Results& results, const PathCorrection& correction) {
    std::size_t number = 0;
    for (std::size_t i = 0; i < results.loops.size(); ++i)
        if (results.loops[i].accepted && results.loops[i].stamp_ns <= correction.stamp_ns) number = i + 1;
    return number;
}

std::string title_of(const Results& results, std::size_t i) {
    const PathCorrection& correction = results.corrections[i];
    const std::size_t loop = loop_of(results, correction);
    return (loop > 0 ? "loop " + std::to_string(loop) : std::string("a loop")) + " closes " +
           misclosure_text(correction.T_before_after);
}

std::string subtitle_of(const Results& results, std::size_t i, StampNs first_stamp_ns) {
    const PathCorrection& correction = results.corrections[i];
    return tick_text(seconds_between(first_stamp_ns, correction.stamp_ns), 0.1) +
           " s into the log  \u00b7  correction " + std::to_string(i + 1) + " of " +
           std::to_string(results.corrections.size()) + "  \u00b7  " + grouped(correction.after.size()) +
           " scans of the map, moved by " + tick_text(largest_move_m(correction), 0.01) + " m at most";
}

}  // namespace

std::vector<std::filesystem::path> write_correction_pictures(const Results& results, StampNs first_stamp_ns,
                                                             const std::string& run_title,
                                                             const std::filesystem::path& folder) {
    std::vector<std::filesystem::path> files;
    if (!results.corrections.empty()) std::filesystem::create_directories(folder);
    for (const std::size_t i : worth_a_picture(results.corrections)) {
        const PathCorrection& correction = results.corrections[i];
        const CorrectionContent content{correction, results.frame_points_base_m,
                                        run_title + ": " + title_of(results, i),
                                        subtitle_of(results, i, first_stamp_ns)};
        files.push_back(folder / ("correction_" + std::to_string(i + 1) + ".png"));
        write_png(draw_correction(content, correction_picture_size(content)), files.back());
    }
    return files;
}

}  // namespace loopline
