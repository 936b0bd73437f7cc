#include "commands/check_report.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>

#include "commands/terminal.h"
#include "config/did_you_mean.h"

namespace loopline {
namespace {

std::string item(const std::string& text, std::size_t width) {
    return "  " + wrapped(text, width, 6, 2) + "\n";
}

std::string rate_text(const SensorSurvey& sensor) {
    const double span_s = seconds_between(sensor.first_stamp_ns, sensor.last_stamp_ns);
    if (sensor.count < 2 || span_s <= 0) return {};
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), ", %.3g Hz", static_cast<double>(sensor.count - 1) / span_s);
    return text.data();
}

std::string logs_text(const LogSource& source, std::size_t width) {
    std::string text;
    for (std::size_t i = 0; i < source.inputs(); ++i) {
        const auto& reader = source.reader(i);
        text += item(reader.path() + ": " + std::to_string(reader.objects()) + " objects in " +
                         std::to_string(reader.file_bytes()) + " bytes",
                     width);
    }
    return text;
}

/// ", 361 beams over 180 deg" of a planar scanner.
std::string beams_text(const SensorFacts& facts) {
    if (facts.beams == 0) return {};
    std::array<char, 96> text{};
    std::snprintf(text.data(), text.size(), ", %zu beams over %.4g deg%s", facts.beams,
                  static_cast<double>(facts.aperture_rad) * 180 / M_PI,
                  facts.varies ? " at first (they vary)" : "");
    return text.data();
}

/// A scanner steps by a round part of a degree. Where the aperture is that of one beam more than there are,
/// the log has most likely forgotten that n beams make n - 1 steps, and every angle is a little off.
std::vector<std::string> aperture_doubts(const LogFacts& facts) {
    std::vector<std::string> sentences;
    for (const auto& [key, sensor] : facts.sensors()) {
        if (sensor.beams < 3) continue;
        const double aperture_deg = static_cast<double>(sensor.aperture_rad) * 180 / M_PI,
                     step_deg = aperture_deg / static_cast<double>(sensor.beams);
        const bool round = std::abs(step_deg * 8 - std::round(step_deg * 8)) < 1e-3;
        if (!round) continue;
        std::array<char, 320> text{};
        std::snprintf(text.data(), text.size(),
                      " has %zu beams over %.4g deg, which is a step of %.4g deg; if the scanner steps by "
                      "%.4g deg, set "
                      "[mount] aperture_deg = %.5g",
                      sensor.beams, aperture_deg, aperture_deg / static_cast<double>(sensor.beams - 1),
                      step_deg, aperture_deg - step_deg);
        sentences.push_back(sensor_name({short_class_name(key.first), key.second}) + text.data());
    }
    return sentences;
}

std::string sensors_text(const LogFacts& facts, const LogSurvey& survey, std::size_t width) {
    const StampNs start_ns = survey.earliest_stamp_ns();
    std::map<LogFacts::SensorKey, std::string> beams;
    for (const auto& [key, sensor] : facts.sensors())
        beams[{short_class_name(key.first), key.second}] = beams_text(sensor);
    std::string text;
    for (const auto& [key, sensor] : survey.sensors())
        text += item(sensor_name(key) + ": " + std::to_string(sensor.count) + rate_text(sensor) + beams[key] +
                         ", from " + seconds_since(start_ns, sensor.first_stamp_ns) + " s to " +
                         seconds_since(start_ns, sensor.last_stamp_ns) + " s, longest step " +
                         seconds_since(0, sensor.longest_gap_ns) + " s",
                     width);
    for (const auto& remark : survey.remarks()) text += item(remark, width);
    return text;
}

std::string list_text(const std::string& title, const std::vector<std::string>& sentences,
                      std::size_t width) {
    if (sentences.empty()) return {};
    std::string text = "\n" + title + "\n";
    for (const auto& sentence : sentences) text += item(sentence, width);
    return text;
}

void append(std::vector<std::string>& to, const std::vector<std::string>& more) {
    to.insert(to.end(), more.begin(), more.end());
}

}  // namespace

NeedsReport needs_report(const Experiment& experiment, const LogFacts& facts) {
    NeedsReport report;
    std::map<std::string, std::string> publishers;  // of the modules so far
    const auto look_at = [&](const ModuleInfo& info) {
        std::vector<std::string> found;
        for (const auto& need : info.needs) {
            const auto published = publishers.find(short_class_name(need));
            if (published != publishers.end())
                found.push_back(need + " (from " + published->second + ")");
            else if (facts.has_class(need))
                found.push_back(need + " (in the log)");
            else
                report.missing.push_back(info.name + " needs " + need +
                                         ", which is not in the log, and no module before it publishes it");
        }
        if (!found.empty()) report.lines.push_back(info.name + " takes " + listing(found));
        for (const auto& name : info.publishes) publishers.emplace(short_class_name(name), info.name);
    };
    for (const auto& module : experiment.modules) look_at(module->info());
    publishers.clear();
    for (const auto& builder : experiment.map_builders) {
        const ModuleInfo info = builder->info();
        report.undrawn.push_back(undrawn_map(info, facts));
        if (report.undrawn.back().empty()) {
            report.undrawn.pop_back();
            look_at(info);
        }
    }
    return report;
}

CheckReport check_report(const Experiment& experiment, const LogSource& source, const LogSurvey& survey,
                         std::size_t width) {
    const auto needs = needs_report(experiment, source.facts());
    std::vector<std::string> faults = source.damages();
    const bool nothing = survey.sensors().empty();
    if (nothing && faults.empty()) faults.push_back("the log holds no observation");
    if (!nothing) append(faults, needs.missing);
    std::vector<std::string> warnings = source.warnings();
    append(warnings, survey.complaints());
    append(warnings, aperture_doubts(source.facts()));
    if (!nothing) append(warnings, needs.undrawn);

    CheckReport report;
    report.text =
        wrapped(experiment.config_path + " is right: it runs " + listing(experiment.run.modules) +
                    (experiment.run.maps.empty() ? "" : ", and the maps " + listing(experiment.run.maps)),
                width, 2, 0) +
        "\n";
    report.text += "\nLogs:\n" + logs_text(source, width);
    if (!nothing)
        report.text +=
            item(utc_text(survey.earliest_stamp_ns()) + ", " +
                     seconds_since(survey.earliest_stamp_ns(), survey.latest_stamp_ns()) + " s long",
                 width) +
            "\nSensors (times since the first stamp):\n" + sensors_text(source.facts(), survey, width);
    report.text += list_text("Modules:", needs.lines, width) + list_text("To look at:", warnings, width) +
                   list_text("Wrong:", faults, width);

    report.verdict = faults.empty() ? exit_done : exit_input_data;
    const bool partly = needs.missing.empty() && !nothing;
    if (faults.empty() && warnings.empty())
        report.text += "\nVerdict: good to run.\n";
    else if (faults.empty())
        report.text += "\nVerdict: it will run; see above what to look at.\n";
    else if (partly)
        report.text +=
            "\nVerdict: damaged; a run saves what lies before the damage, and ends with exit code 3.\n";
    else
        report.text += "\nVerdict: it can't run on this log.\n";
    return report;
}

}  // namespace loopline
