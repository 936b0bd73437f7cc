#include "evaluate/report.h"

#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <nlohmann/json.hpp>

namespace loopline {
namespace {

__attribute__((format(printf, 2, 3))) void print(std::string& out, const char* format, ...) {
    char line[256];
    va_list arguments;
    va_start(arguments, format);
    std::vsnprintf(line, sizeof line, format, arguments);
    va_end(arguments);
    out += line;
}

void print_row(std::string& out, const char* name, const char* unit, const Statistics& s) {
    print(out, "%-24s %-4s %10.4f %10.4f %10.4f %10.4f %10.4f %8zu\n", name, unit, s.rmse, s.mean,
          s.std_deviation, s.median, s.max, s.count);
}

const char* name_of(Alignment alignment) {
    switch (alignment) {
        case Alignment::planar:
            return "planar";
        case Alignment::spatial:
            return "spatial";
        case Alignment::none:
            return "none";
        case Alignment::automatic:
            break;
    }
    return "automatic";
}

}  // namespace

std::string report_json(const EvaluationReport& report) {
    nlohmann::ordered_json json;
    json["poses_estimate"] = report.poses_estimate;
    if (report.absolute) {
        const Statistics& s = report.absolute->distance_m;
        json["poses_reference"] = report.poses_reference;
        json["poses_matched"] = report.poses_matched;
        json["way_m"] = report.way_m;
        json["alignment"] = name_of(report.absolute->alignment);
        json["ate_rmse_m"] = s.rmse;
        json["ate_mean_m"] = s.mean;
        json["ate_median_m"] = s.median;
        json["ate_std_m"] = s.std_deviation;
        json["ate_max_m"] = s.max;
    }
    if (report.relative && report.relative->translation_m.count > 0) {
        const Statistics &t = report.relative->translation_m, &r = report.relative->rotation_deg;
        json["rpe_steps"] = t.count;
        json["rpe_translation_m"] = t.rmse;
        json["rpe_translation_mean_m"] = t.mean;
        json["rpe_translation_max_m"] = t.max;
        json["rpe_rotation_deg"] = r.rmse;
        json["rpe_rotation_mean_deg"] = r.mean;
        json["rpe_rotation_max_deg"] = r.max;
    }
    if (report.kitti) {
        json["kitti_segments"] = report.kitti->segments.size();
        json["kitti_translation_percent"] = report.kitti->translation_percent;
        json["kitti_rotation_deg_per_m"] = report.kitti->rotation_deg_per_m;
    }
    if (report.relations) {
        const Statistics &t = report.relations->translation_m, &r = report.relations->rotation_deg;
        json["relations_total"] = report.relations->relations;
        json["relations_used"] = t.count;
        json["relations_translation_mean_m"] = t.mean;
        json["relations_translation_std_m"] = t.std_deviation;
        json["relations_translation_rms_m"] = t.rmse;
        json["relations_translation_max_m"] = t.max;
        json["relations_rotation_mean_deg"] = r.mean;
        json["relations_rotation_std_deg"] = r.std_deviation;
        json["relations_rotation_rms_deg"] = r.rmse;
        json["relations_rotation_max_deg"] = r.max;
    }
    return json.dump(4) + "\n";
}

std::string report_text(const EvaluationReport& report, const std::string& rpe_step) {
    std::string out;
    if (report.absolute)
        print(out, "%zu of %zu poses matched with the reference's %zu, %.1f m; %s alignment\n",
              report.poses_matched, report.poses_estimate, report.poses_reference, report.way_m,
              name_of(report.absolute->alignment));
    if (report.relations)
        print(out, "%zu of %zu relations used\n", report.relations->translation_m.count,
              report.relations->relations);
    print(out, "%-24s %-4s %10s %10s %10s %10s %10s %8s\n", "", "", "rmse", "mean", "std", "median", "max",
          "count");
    if (report.absolute) print_row(out, "ATE", "m", report.absolute->distance_m);
    if (report.relative && report.relative->translation_m.count > 0) {
        print_row(out, ("RPE over " + rpe_step).c_str(), "m", report.relative->translation_m);
        print_row(out, ("RPE over " + rpe_step).c_str(), "deg", report.relative->rotation_deg);
    }
    if (report.relations) {
        print_row(out, "relations", "m", report.relations->translation_m);
        print_row(out, "relations", "deg", report.relations->rotation_deg);
    }
    if (report.kitti)
        print(out, "KITTI segments of 100 .. 800 m: %.4f %%, %.6f deg/m over %zu segments\n",
              report.kitti->translation_percent, report.kitti->rotation_deg_per_m,
              report.kitti->segments.size());
    return out;
}

}  // namespace loopline
