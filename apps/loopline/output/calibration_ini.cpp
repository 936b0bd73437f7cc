#include "output/calibration_ini.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "config/ini_file.h"
#include "config/ini_text.h"

namespace loopline {
namespace {

/// Digits down to a tenth or a hundredth of the standard error.
std::string rounded(double value, double standard_error) {
    if (standard_error <= 0 || value == 0) return number_text(value);
    const double digits = std::ceil(std::log10(std::abs(value) / standard_error)) + 2;
    char text[40];
    std::snprintf(text, sizeof text, "%.*g", static_cast<int>(std::clamp(digits, 2.0, 15.0)), value);
    return number_text(*number_from_text(text));
}

std::string key_text(const CalibratedKey& key, const ParameterTable& table) {
    const auto left_out = [&key](const std::string& reason) {
        return ini_comment(key.key + " is left out: " + reason);
    };
    if (!key.value) return left_out(key.comment);
    const std::string value = rounded(*key.value, key.standard_error);
    const Parameter* parameter = table.find(key.key);
    if (parameter == nullptr) return left_out("[" + table.section() + "] has no such key");
    if (const auto clause = parameter->parse(value)) return left_out("the log's " + value + " " + *clause);
    const std::string error =
        key.standard_error > 0
            ? "Standard error " + rounded(key.standard_error, key.standard_error / 10) + "; "
            : "";
    return ini_comment(error + key.comment) + ini_assignment(key.key, value) + "\n";
}

}  // namespace

std::string calibration_ini_text(const Calibration& calibration, Module& module) {
    const ParameterTable table = module.parameters();
    std::string text = "[" + calibration.section + "]\n";
    for (const auto& sentence : calibration.remarks) text += ini_comment(sentence);
    for (const CalibratedKey& key : calibration.keys) text += "\n" + key_text(key, table);
    return text;
}

}  // namespace loopline
