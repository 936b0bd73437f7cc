/// What one sees first: name, status, warnings, figures.
#include <algorithm>
#include <array>
#include <cstdio>
#include <ctime>
#include <string_view>

#include "render/report/html.h"
#include "render/report/sections.h"

namespace loopline {
namespace {

using html::escaped;

std::string text_of(const nlohmann::ordered_json& object, const char* key) {
    const auto found = object.find(key);
    return found != object.end() && found->is_string() ? found->get<std::string>() : std::string();
}

struct Badge {
    const char *css_class, *text;
};

Badge badge_of(const std::string& status) {
    if (status == "done") return {"good", "\u2713 Done"};
    if (status == "refused") return {"bad", "\u2717 Refused"};
    if (status == "damaged_input") return {"warn", "\u26a0 Input damaged"};
    if (status == "interrupted") return {"warn", "\u26a0 Interrupted"};
    return {"warn", "\u26a0 Unknown end"};
}

/// "2006-01-21 09:03:45 UTC"; empty for stamps that are no dates, as in simulated logs.
std::string date_text(StampNs stamp_ns) {
    const std::time_t seconds = stamp_ns / 1'000'000'000;
    constexpr std::time_t year_1980 = 315'532'800;
    std::tm parts{};
    if (seconds < year_1980 || !gmtime_r(&seconds, &parts)) return {};
    char text[64];
    std::strftime(text, sizeof text, "%Y-%m-%d %H:%M:%S UTC", &parts);
    return text;
}

std::string alert(const char* css_class, const std::string& title, const std::string& sentence) {
    return "<div class=\"alert " + std::string(css_class) + "\" role=\"alert\"><b>" + title + "</b><span>" +
           escaped(sentence) + "</span></div>\n";
}

struct Headline {
    const char *key, *name, *unit;
};

/// In the order of their tiles.
constexpr std::array<Headline, 23> headlines = {
    {{"ate_rmse_m", "absolute trajectory error, RMS", "m"},
     {"ate_max_m", "largest error", "m"},
     {"end_error_m", "error at the end", "m"},
     {"earth_horizontal_rmse_m", "error on the Earth, horizontal, RMS", "m"},
     {"gnss_horizontal_rmse_m", "the same of the fixes alone", "m"},
     {"relations_translation_mean_m", "error of relations, mean", "m"},
     {"relations_rotation_mean_deg", "turn error of relations, mean", "\u00b0"},
     {"points_mean_error_m", "error of feature points, mean", "m"},
     {"points_max_error_m", "error of feature points, largest", "m"},
     {"survey_median_m", "survey cloud to true walls, median", "m"},
     {"survey_odometry_median_m", "the same by dead reckoning", "m"},
     {"distance_m", "distance travelled", "m"},
     {"log_s", "length of the log", "s"},
     {"scans_used", "scans with a pose", ""},
     {"lines", "walls in the map", ""},
     {"updates", "updates", ""},
     {"loops_found", "loops closed", ""},
     {"gnss_used", "GNSS fixes used", ""},
     {"nees_mean", "normalised error squared, mean", ""},
     {"real_time_factor", "times real time", "\u00d7"},
     {"cpu_s", "processor time", "s"},
     {"peak_memory_mb", "peak memory", "MB"},
     {"rejected", "observations rejected", ""}}};

std::string value_text(const nlohmann::ordered_json& value) {
    if (value.is_number_integer()) return value.dump();
    if (value.is_number()) return html::number(value.get<double>());
    return value.is_string() ? value.get<std::string>() : value.dump();
}

}  // namespace

std::string run_name(const RunFiles& run) {
    const std::string config = std::filesystem::path(text_of(run.manifest, "config")).stem().string();
    if (!config.empty()) return config;
    std::error_code error;
    const auto folder = std::filesystem::absolute(run.folder, error).lexically_normal();
    return (folder.has_filename() ? folder : folder.parent_path()).filename().string();
}

std::string header_section(const RunFiles& run) {
    const Badge badge = badge_of(text_of(run.metrics, "status"));
    std::string lead;
    const auto add = [&lead](const std::string& part) {
        if (!part.empty()) lead += (lead.empty() ? "" : " \u00b7 ") + part;
    };
    const auto inputs = run.manifest.find("inputs");
    if (inputs != run.manifest.end() && inputs->is_array())
        for (const auto& input : *inputs)
            if (input.is_object())
                add(escaped(std::filesystem::path(text_of(input, "path")).filename().string()));
    if (!run.estimate.empty()) add(date_text(run.estimate.front().stamp_ns));
    return "<header><h1>" + escaped(run_name(run)) + " <span class=\"badge " + badge.css_class + "\">" +
           badge.text + "</span></h1>\n<p class=\"quiet\">" + lead + "</p></header>\n";
}

std::string alerts_section(const RunFiles& run) {
    std::string out;
    const std::string status = text_of(run.metrics, "status");
    if (run.metrics.empty())
        out += alert("bad", "No figures",
                     "metrics.json is missing or damaged; this report shows what else there is.");
    if (const std::string refused = text_of(run.metrics, "refused"); !refused.empty())
        out += alert("bad", "The estimate was refused", refused);
    if (const std::string damage = text_of(run.metrics, "input_damage"); !damage.empty())
        out += alert("warn", "The input is damaged",
                     damage + " What was read before the damage is processed and shown here.");
    if (status == "interrupted")
        out += alert("warn", "The run was interrupted", "This report shows what was done until then.");
    const auto warnings = run.manifest.find("warnings");
    if (warnings != run.manifest.end() && warnings->is_array())
        for (const auto& warning : *warnings)
            if (warning.is_string()) out += alert("warn", "Warning", warning.get<std::string>());
    return out;
}

std::string figures_section(const RunFiles& run) {
    std::string tiles, rows;
    const auto tile = [&tiles](const std::string& value, const std::string& unit, const std::string& name) {
        tiles += "<div class=\"tile\"><div class=\"value\">" + escaped(value) +
                 (unit.empty() ? "" : " <small>" + escaped(unit) + "</small>") +
                 "</div><div class=\"name\">" + escaped(name) + "</div></div>\n";
    };
    for (const auto& [key, name, unit] : headlines) {
        const auto value = run.metrics.find(key);
        const bool no_scans = std::string_view(key) == "scans_used" && value != run.metrics.end() &&
                              *value == 0 && text_of(run.metrics, "status") == "done";  // the log has none
        if (value != run.metrics.end() && value->is_number() && !no_scans)
            tile(value->is_number_integer() ? value->dump() : html::number(value->get<double>(), 3), unit,
                 name);
    }
    if (!run.estimate.empty() && !run.odometry.empty()) {
        const double apart_m =
            (run.estimate.back().T_map_base.translation_m - run.odometry.back().T_map_base.translation_m)
                .norm();
        tile(html::number(apart_m, 3), "m", "apart from dead reckoning at the end");
    }
    for (const auto& [key, value] : run.metrics.items())
        if (!value.is_structured())
            rows += "<tr><td>" + escaped(key) + "</td><td>" + escaped(value_text(value)) + "</td></tr>\n";
    std::string out;
    if (!tiles.empty()) out += "<section class=\"tiles\">\n" + tiles + "</section>\n";
    if (!rows.empty())
        out += "<details><summary>All figures</summary><div class=\"wide\" style=\"border:0\"><table>" +
               rows + "</table></div></details>\n";
    return out;
}

}  // namespace loopline
