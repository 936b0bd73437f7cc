/// Pictures, and the lists of modules, inputs and files.
#include <algorithm>
#include <sstream>

#include "render/report/embedded_picture.h"
#include "render/report/html.h"
#include "render/report/sections.h"
#include "render/report/table_cells.h"

namespace loopline {
namespace {

using html::escaped;

constexpr std::size_t most_bytes_per_picture = 500'000;  // keeps the page well under 3 MB

bool has_cloud(const RunFiles& run) {
    return std::any_of(run.files.begin(), run.files.end(),
                       [](const RunFile& file) { return file.path == "map.cloud.ply"; });
}

std::string caption_of(const RunFiles& run, const std::string& stem) {
    if (stem == "top" && has_cloud(run)) return "The map from above, coloured by height";
    if (stem == "top") return "The map from above";
    if (stem == "axonometric" && has_cloud(run))
        return "The map from aside, coloured by height; where the path is hidden, it is dashed";
    if (stem == "axonometric") return "Axonometric view; walls of a planar scan are raised to be seen";
    if (stem == "before_after") return "Scan points placed by dead reckoning, and by the estimate";
    if (stem == "survey_top") return "The survey cloud from above, by dead reckoning and by corrected poses";
    if (stem == "survey_axonometric")
        return "The survey cloud from aside, by dead reckoning and by corrected poses";
    if (stem == "earth_plan") return "The path on the Earth, with and without the fixes of the receiver";
    if (stem == "earth_height") return "Its height over the way";
    if (stem == "earth_error") return "Its errors, in bands of three standard deviations";
    if (stem == "follow") return "Behind the vehicle at its last pose";
    std::string text = stem;
    std::replace(text.begin(), text.end(), '_', ' ');
    return text;
}

std::string figure_of(const RunFiles& run, const std::string& path) {
    return picture_figure(run.folder, path, caption_of(run, std::filesystem::path(path).stem().string()),
                          most_bytes_per_picture);
}

}  // namespace

std::string pictures_section(const RunFiles& run) {
    std::vector<std::string> paths;
    for (const auto& file : run.files)
        if (is_snapshot(file.path) && !correction_number(file.path)) paths.push_back(file.path);
    const auto rank = [](const std::string& path) {
        const char* order[] = {
            "snapshots/top.png",          "snapshots/before_after.png",       "snapshots/axonometric.png",
            "snapshots/survey_top.png",   "snapshots/survey_axonometric.png", "snapshots/earth_plan.png",
            "snapshots/earth_height.png", "snapshots/earth_error.png"};
        return std::find(std::begin(order), std::end(order), path) - std::begin(order);
    };
    std::stable_sort(paths.begin(), paths.end(),
                     [&](const auto& a, const auto& b) { return rank(a) < rank(b); });
    std::string figures;
    constexpr std::size_t most_pictures = 8;
    for (std::size_t i = 0; i < paths.size() && i < most_pictures; ++i) figures += figure_of(run, paths[i]);
    return figures.empty() ? ""
                           : "<h2>Pictures</h2>\n<section class=\"pictures\">\n" + figures + "</section>\n";
}

std::string feature_points_section(const RunFiles& run) {
    std::string rows;
    std::istringstream lines(run.feature_points_table);
    for (std::string line; std::getline(lines, line);) {
        if (line.size() < 4 || line.front() != '|' || line.compare(0, 3, "| -") == 0) continue;
        const std::string tag = rows.empty() ? "th" : "td";
        std::string row;
        std::istringstream cells(line.substr(1));
        for (std::string text; std::getline(cells, text, '|');)
            row += "<" + tag + ">" + escaped(text) + "</" + tag + ">";
        rows += "<tr>" + row + "</tr>\n";
    }
    if (rows.empty()) return {};
    return "<h2>Feature points</h2>\n<div class=\"wide\"><table>" + rows + "</table></div>\n";
}

std::string modules_section(const RunFiles& run) {
    const auto modules = run.metrics.find("modules");
    if (modules == run.metrics.end() || !modules->is_object() || modules->empty()) return {};
    // Its work during the log, and what it does when the log has ended.
    const auto total_ms = [](const nlohmann::ordered_json& m) {
        return number_at(m, "calls") * number_at(m, "mean_ms") + number_at(m, "finish_ms");
    };
    double largest_ms = 1e-9;
    for (const auto& [name, module] : modules->items())
        if (module.is_object()) largest_ms = std::max(largest_ms, total_ms(module));
    std::string rows;
    for (const auto& [name, module] : modules->items()) {
        if (!module.is_object()) continue;
        const double share_percent = 100 * total_ms(module) / largest_ms;
        rows += "<tr>" + cell(escaped(name)) + cell(html::number(number_at(module, "calls")));
        for (const double ms : {number_at(module, "mean_ms"), number_at(module, "worst_ms"),
                                number_at(module, "finish_ms"), total_ms(module)})
            rows += cell(html::number(ms, 3));
        rows += cell("<span class=\"bar\" style=\"width:" + html::number(share_percent, 3) + "%\"></span>",
                     "share") +
                "</tr>\n";
    }
    return "<h2>Time spent in modules</h2>\n<div "
           "class=\"wide\"><table><tr><th>module</th><th>calls</th><th>mean, ms</th><th>worst, ms</th>"
           "<th>after the log, ms</th><th>in all, ms</th><th></th></tr>\n" +
           rows + "</table></div>\n";
}

std::string inputs_section(const RunFiles& run) {
    const auto inputs = run.manifest.find("inputs");
    if (inputs == run.manifest.end() || !inputs->is_array() || inputs->empty()) return {};
    std::string rows;
    for (const auto& input : *inputs) {
        if (!input.is_object()) continue;
        const auto text = [&input](const char* key) {
            return input.contains(key) && input[key].is_string() ? input[key].get<std::string>()
                                                                 : std::string();
        };
        const std::string damage = text("damage");
        rows += "<tr>" + cell(escaped(text("path")), "left") +
                cell(html::file_size(static_cast<std::uintmax_t>(number_at(input, "bytes"))), "size") +
                cell(html::number(number_at(input, "objects_read"))) +
                cell(damage.empty() ? "read to its end" : escaped(damage), "left") +
                cell(escaped(text("sha256")), "hash") + "</tr>\n";
    }
    return "<h2>Inputs</h2>\n<div class=\"wide\"><table><tr><th>file</th><th>size</th><th>objects</th><th "
           "class=\"left\">state</th><th class=\"left\">SHA-256</th></tr>\n" +
           rows + "</table></div>\n";
}

std::string config_section(const RunFiles& run) {
    if (run.config_ini.empty()) return {};
    return "<h2>Configuration</h2>\n<details><summary>Every parameter of this run</summary><pre>" +
           escaped(run.config_ini) + "</pre></details>\n";
}

std::string files_section(const RunFiles& run) {
    std::string items;
    for (const auto& file : run.files)
        items += "<li><a href=\"" + html::relative_link(file.path) + "\">" + escaped(file.path) +
                 "</a> <span class=\"quiet\">" + html::file_size(file.bytes) + "</span></li>\n";
    return items.empty() ? "" : "<h2>Files</h2>\n<ul class=\"files\">\n" + items + "</ul>\n";
}

}  // namespace loopline
