#include "output/metrics_json.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "api/loop_closer.h"
#include "output/line_map_csv.h"
#include "output/output_file.h"
#include "output/run_directory.h"

namespace loopline {
namespace {

using nlohmann::ordered_json;

void set_finite(ordered_json& json, const std::string& key, double value) {
    if (std::isfinite(value)) json[key] = value;
}

/// Damage of all inputs as one text; empty if there is none.
std::string damage_of(const std::vector<InputRecord>& inputs) {
    std::string all;
    for (const auto& input : inputs) {
        if (input.damage.empty()) continue;
        if (!all.empty()) all += ' ';
        all += input.damage;
    }
    return all;
}

std::size_t poses_not_finite(const Trajectory& trajectory) {
    const auto bad = [](const TrajectoryEntry& e) {
        return !e.T_map_base.translation_m.allFinite() || !e.T_map_base.rotation.coeffs().allFinite();
    };
    return static_cast<std::size_t>(
        std::count_if(trajectory.entries().begin(), trajectory.entries().end(), bad));
}

void set_host_figures(ordered_json& json, const RunRecord& record) {
    json["status"] = record.status;
    json["exit_code"] = record.exit_code;
    if (const std::string damage = damage_of(record.inputs); !damage.empty()) json["input_damage"] = damage;
    if (record.results.refused) json["refused"] = *record.results.refused;
    json["scans_read"] = record.scans_read;
    json["scans_used"] = record.scans_used;
    const double log_s = seconds_between(record.first_stamp_ns, record.last_stamp_ns);
    if (log_s > 0) json["log_s"] = log_s;
    set_finite(json, "wall_s", record.wall_s);
    set_finite(json, "cpu_s", record.cpu_s);
    if (log_s > 0 && record.wall_s > 0) set_finite(json, "real_time_factor", log_s / record.wall_s);
    if (record.peak_memory_mb > 0) set_finite(json, "peak_memory_mb", record.peak_memory_mb);
    if (record.trajectory && !record.trajectory->empty()) {
        set_finite(json, "distance_m", record.trajectory->length_m());
        if (const std::size_t bad = poses_not_finite(*record.trajectory); bad > 0)
            json["poses_left_out"] = bad;
    }
    if (record.results.line_map) {
        const auto& lines = *record.results.line_map;
        const auto good = static_cast<std::size_t>(std::count_if(lines.begin(), lines.end(), is_finite));
        json["lines"] = good;
        if (good < lines.size()) json["lines_left_out"] = lines.size() - good;
    }
}

void set_module_figures(ordered_json& json, const std::map<std::string, MetricValue>& metrics) {
    for (const auto& [key, value] : metrics) {
        if (json.contains(key)) continue;
        if (const auto* number = std::get_if<double>(&value))
            set_finite(json, key, *number);
        else
            std::visit([&json, &name = key](const auto& v) { json[name] = v; }, value);
    }
}

const char* decision_text(const LoopDecision& loop) {
    if (loop.accepted) return "accepted";
    return loop.waits ? "waits" : "refused";
}

/// Divided, not multiplied, so that 381.391739 is not written as 381.39173900000003.
double seconds_since(StampNs first_stamp_ns, StampNs stamp_ns) {
    return static_cast<double>(stamp_ns - first_stamp_ns) / 1e9;
}

ordered_json loop_json(const LoopDecision& loop, std::size_t number, StampNs first_stamp_ns) {
    constexpr double degrees = 180 / M_PI;
    ordered_json json;
    json["number"] = number;
    json["loop"] = loop_name(loop.stamp_ns, loop.old_stamp_ns);
    json["stamp_s"] = seconds_since(first_stamp_ns, loop.stamp_ns);
    json["old_stamp_s"] = seconds_since(first_stamp_ns, loop.old_stamp_ns);
    set_finite(json, "way_m", loop.way_m);
    set_finite(json, "score", loop.score);
    set_finite(json, "rival_score", loop.rival_score);
    set_finite(json, "shift_m", loop.shift_m);
    set_finite(json, "shift_deg", loop.shift_rad * degrees);
    set_finite(json, "sigma_m", loop.sigma_m);
    set_finite(json, "sigma_deg", loop.sigma_rad * degrees);
    json["decision"] = decision_text(loop);
    json["reason"] = loop.reason;
    return json;
}

}  // namespace

ordered_json metrics_json(const RunRecord& record) {
    ordered_json json;
    set_host_figures(json, record);
    set_module_figures(json, record.results.metrics);
    ordered_json loops = ordered_json::array();
    for (const LoopDecision& loop : record.results.loops)
        loops.push_back(loop_json(loop, loops.size() + 1, record.first_stamp_ns));
    if (!loops.empty()) json["loops"] = std::move(loops);
    ordered_json modules = ordered_json::object();
    for (const auto& [name, timing] : record.modules) {
        auto& module = modules[name];
        module["calls"] = timing.calls;
        module["mean_ms"] = timing.calls > 0 ? timing.total_ms / static_cast<double>(timing.calls) : 0.0;
        module["worst_ms"] = timing.worst_ms;
        module["finish_ms"] = timing.finish_ms;
    }
    json["modules"] = modules;
    return json;
}

void write_metrics(const std::filesystem::path& folder, const RunRecord& record) {
    const auto replace_bad_utf8 = ordered_json::error_handler_t::replace;
    write_whole_file(folder / "metrics.json",
                     metrics_json(record).dump(2, ' ', false, replace_bad_utf8) + "\n");
}

}  // namespace loopline
