#include "sweep/sweep_table.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "api/parameters.h"
#include "commands/command.h"

namespace loopline {
namespace {

void add_numbers(const nlohmann::ordered_json& object, const std::string& prefix,
                 std::map<std::string, double>& flat) {
    for (const auto& [key, value] : object.items()) {
        if (value.is_number()) flat[prefix + key] = value.get<double>();
        if (value.is_object()) add_numbers(value, prefix + key + ".", flat);
    }
}

/// Four significant digits, whole numbers whole.
std::string short_number(double value) {
    char text[48];
    const bool whole = value == std::round(value) && std::abs(value) < 1e12;
    std::snprintf(text, sizeof text, whole ? "%.0f" : std::abs(value) >= 1000 ? "%.1f" : "%.4g", value);
    return text;
}

std::string quoted_cell(const std::string& text) {
    if (text.find_first_of(",\"\n") == std::string::npos) return text;
    std::string quoted = "\"";
    for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
    return quoted + "\"";
}

std::string csv_row(const std::vector<std::string>& cells) {
    std::string row;
    for (std::size_t i = 0; i < cells.size(); ++i) row += (i > 0 ? "," : "") + quoted_cell(cells[i]);
    return row + "\n";
}

std::string markdown_row(const std::vector<std::string>& cells) {
    std::string row = "|";
    for (const auto& cell : cells) row += " " + cell + " |";
    return row + "\n";
}

std::string key_alone(const std::string& key) {
    return key.substr(key.find('.') + 1);
}

}  // namespace

std::map<std::string, double> flat_metrics(const nlohmann::ordered_json& metrics) {
    std::map<std::string, double> flat;
    if (!metrics.is_object()) return flat;
    add_numbers(metrics, "", flat);
    const auto modules = metrics.find("modules");
    if (modules == metrics.end() || !modules->is_object()) return flat;
    double total_ms = 0;
    for (const auto& [name, module] : modules->items()) {
        const auto calls = flat.find("modules." + name + ".calls"),
                   mean = flat.find("modules." + name + ".mean_ms");
        if (calls != flat.end() && mean != flat.end()) total_ms += calls->second * mean->second;
    }
    flat["modules_s"] = total_ms / 1000;
    return flat;
}

std::vector<std::string> usual_metrics(const std::vector<SweepRun>& runs) {
    std::vector<std::string> found;
    for (const char* name : {"points_mean_error_m", "points_max_error_m", "ate_rmse_m", "ate_max_m",
                             "relations_translation_mean_m", "nees_mean", "modules_s", "cpu_s", "updates",
                             "predictions", "re_predictions"})
        if (std::any_of(runs.begin(), runs.end(),
                        [&](const SweepRun& run) { return run.metrics.count(name) > 0; }))
            found.emplace_back(name);
    return found;
}

MetricSummary summary_of(const std::vector<SweepRun>& runs, const std::vector<std::string>& combination,
                         const std::string& metric) {
    std::vector<double> values;
    for (const SweepRun& run : runs)
        if (const auto found = run.metrics.find(metric);
            run.combination == combination && found != run.metrics.end())
            values.push_back(found->second);
    MetricSummary summary;
    summary.count = values.size();
    if (values.empty()) return summary;
    std::sort(values.begin(), values.end());
    const std::size_t half = values.size() / 2;
    summary.median = values.size() % 2 == 1 ? values[half] : (values[half - 1] + values[half]) / 2;
    for (const double value : values) summary.mean += value / static_cast<double>(values.size());
    summary.min = values.front();
    summary.max = values.back();
    return summary;
}

std::string SweepTable::markdown() const {
    const auto combinations = combinations_of(variations);
    const bool single = std::all_of(combinations.begin(), combinations.end(), [&](const auto& combination) {
        return std::count_if(runs.begin(), runs.end(),
                             [&](const SweepRun& run) { return run.combination == combination; }) <= 1;
    });
    std::vector<std::string> head, rule;
    for (const Variation& variation : variations) head.push_back(key_alone(variation.key));
    head.emplace_back("runs");
    for (const auto& metric : metrics) head.push_back(metric + (single ? "" : ": mean / median / worst"));
    rule.assign(head.size(), "---:");
    std::string table = markdown_row(head) + markdown_row(rule);
    for (const auto& combination : combinations) {
        std::vector<std::string> cells = combination;
        std::size_t all = 0, good = 0;
        for (const SweepRun& run : runs)
            if (run.combination == combination) ++all, good += run.exit_code == exit_done;
        cells.push_back(good == all ? std::to_string(all)
                                    : std::to_string(good) + " of " + std::to_string(all));
        for (const auto& metric : metrics) {
            const MetricSummary s = summary_of(runs, combination, metric);
            cells.push_back(s.count == 0 ? ""
                            : single     ? short_number(s.median)
                                         : short_number(s.mean) + " / " + short_number(s.median) + " / " +
                                           short_number(s.max));
        }
        table += markdown_row(cells);
    }
    return table;
}

std::string SweepTable::csv() const {
    std::vector<std::string> head;
    for (const Variation& variation : variations) head.push_back(variation.key);
    head.insert(head.end(), {"runs", "runs_good"});
    for (const auto& metric : metrics)
        for (const char* what : {"_mean", "_median", "_min", "_max"}) head.push_back(metric + what);
    std::string table = csv_row(head);
    for (const auto& combination : combinations_of(variations)) {
        std::vector<std::string> cells = combination;
        std::size_t all = 0, good = 0;
        for (const SweepRun& run : runs)
            if (run.combination == combination) ++all, good += run.exit_code == exit_done;
        cells.insert(cells.end(), {std::to_string(all), std::to_string(good)});
        for (const auto& metric : metrics) {
            const MetricSummary s = summary_of(runs, combination, metric);
            for (const double value : {s.mean, s.median, s.min, s.max})
                cells.push_back(s.count > 0 ? number_text(value) : std::string());
        }
        table += csv_row(cells);
    }
    return table;
}

std::string SweepTable::csv_of_runs() const {
    std::vector<std::string> head;
    for (const Variation& variation : variations) head.push_back(variation.key);
    head.insert(head.end(), {"log", "exit_code"});
    head.insert(head.end(), metrics.begin(), metrics.end());
    std::string table = csv_row(head);
    for (const SweepRun& run : runs) {
        std::vector<std::string> cells = run.combination;
        cells.insert(cells.end(), {run.log, std::to_string(run.exit_code)});
        for (const auto& metric : metrics) {
            const auto found = run.metrics.find(metric);
            cells.push_back(found != run.metrics.end() ? number_text(found->second) : std::string());
        }
        table += csv_row(cells);
    }
    return table;
}

}  // namespace loopline
