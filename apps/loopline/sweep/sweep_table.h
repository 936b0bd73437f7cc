/// The figures of a sweep: from each run's metrics.json to one table.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "sweep/sweep_plan.h"

namespace loopline {

struct SweepRun {
    std::vector<std::string> combination;  ///< a value for each variation
    std::string log;                       ///< its name
    int exit_code = -1;                    ///< of `loopline run`
    std::map<std::string, double> metrics;
};

/// All numbers of a metrics.json, those inside others as "modules.lines.mean_ms"; and "modules_s": the time
/// spent in all modules during the log, calls times mean.
std::map<std::string, double> flat_metrics(const nlohmann::ordered_json& metrics);

/// Those of the usual metrics that any of the runs has, for who names none.
std::vector<std::string> usual_metrics(const std::vector<SweepRun>& runs);

struct MetricSummary {
    std::size_t count = 0;
    double mean = 0, median = 0, min = 0, max = 0;
};
/// Of the runs with this combination that have the metric.
MetricSummary summary_of(const std::vector<SweepRun>& runs, const std::vector<std::string>& combination,
                         const std::string& metric);

struct SweepTable {
    std::vector<Variation> variations;
    std::vector<std::string> metrics;
    std::vector<SweepRun> runs;

    /// A row a combination: its values, how many runs ended well of how many, and of each metric mean, median
    /// and worst (the largest) over the runs; a single number where each combination has one run.
    std::string markdown() const;
    /// The same with a column for each: metric_mean, metric_median, metric_min, metric_max.
    std::string csv() const;
    /// A row a run.
    std::string csv_of_runs() const;
};

}  // namespace loopline
