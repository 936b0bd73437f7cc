/// Loops: what was found, what came of it, and what it did to the map.
#include <algorithm>
#include <map>

#include "render/report/embedded_picture.h"
#include "render/report/html.h"
#include "render/report/sections.h"
#include "render/report/table_cells.h"
#include "render/scale.h"

namespace loopline {
namespace {

using nlohmann::ordered_json;

constexpr std::size_t most_rows = 20;  // beyond, only accepted loops are unfolded
constexpr std::size_t most_bytes_of_corrections =
    1'000'000;  // keeps the page under 3 MB with its other pictures

std::string string_at(const ordered_json& object, const char* key) {
    const auto found = object.find(key);
    return found != object.end() && found->is_string() ? found->get<std::string>() : std::string();
}

bool is_accepted(const ordered_json& loop) {
    return loop.is_object() && string_at(loop, "decision") == "accepted";
}

std::string decision_badge(const std::string& decision) {
    const char* colours = decision == "accepted" ? "good" : decision == "waits" ? "warn" : "bad";
    return std::string("<span class=\"badge ") + colours + "\">" + html::escaped(decision) + "</span>";
}

std::string loop_row(const ordered_json& loop) {
    const auto number = [&loop](const char* key, double step) {
        const bool is_there = loop.contains(key) && loop[key].is_number();
        return cell(is_there ? tick_text(number_at(loop, key), step) : "");
    };
    return "<tr>" + number("stamp_s", 0.1) + number("old_stamp_s", 0.1) + number("way_m", 0.1) +
           number("score", 0.01) + number("rival_score", 0.01) + number("shift_m", 0.001) +
           number("shift_deg", 0.01) + cell(decision_badge(string_at(loop, "decision")), "left") +
           cell(html::escaped(string_at(loop, "reason")), "left") + "</tr>\n";
}

template <class Want>
std::string loop_table(const ordered_json& loops, Want want) {
    std::string rows;
    for (const auto& loop : loops)
        if (loop.is_object() && want(loop)) rows += loop_row(loop);
    if (rows.empty()) return {};
    return "<div class=\"wide\"><table><tr><th>time, s</th><th>of old scan, s</th><th>way between, m</th>"
           "<th>score</th><th>rival</th><th>shift, m</th><th>turn, \u00b0</th><th "
           "class=\"left\">decision</th>"
           "<th class=\"left\">reason</th></tr>\n" +
           rows + "</table></div>\n";
}

std::string loop_tables(const ordered_json& loops) {
    const auto accepted = static_cast<std::size_t>(std::count_if(loops.begin(), loops.end(), is_accepted));
    if (loops.size() <= most_rows || accepted == loops.size())
        return loop_table(loops, [](const ordered_json&) { return true; });
    return loop_table(loops, is_accepted) + "<details><summary>" + std::to_string(loops.size() - accepted) +
           (accepted > 0 ? " more" : "") + " places that were looked at</summary>" +
           loop_table(loops, [](const ordered_json& loop) { return !is_accepted(loop); }) + "</details>\n";
}

std::string correction_figures(const RunFiles& run) {
    std::map<unsigned, std::string> pictures;
    for (const auto& file : run.files)
        if (const auto number = correction_number(file.path)) pictures[*number] = file.path;
    if (pictures.empty()) return {};
    const std::size_t most_bytes =
        std::min<std::size_t>(400'000, most_bytes_of_corrections / pictures.size());
    std::string figures;
    for (const auto& [number, path] : pictures)
        figures +=
            picture_figure(run.folder, path,
                           "Correction " + std::to_string(number) + ": the map before and after", most_bytes);
    return figures.empty() ? "" : "<section class=\"pictures corrections\">\n" + figures + "</section>\n";
}

}  // namespace

std::string loops_section(const RunFiles& run) {
    const auto loops = run.metrics.find("loops");
    std::string content;
    if (loops != run.metrics.end() && loops->is_array()) content += loop_tables(*loops);
    content += correction_figures(run);
    return content.empty() ? "" : "<h2>Loops</h2>\n" + content;
}

}  // namespace loopline
