#include "output/line_map_csv.h"

#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <optional>
#include <string>
#include <vector>

#include "api/parameters.h"
#include "commands/command.h"
#include "output/output_file.h"

namespace loopline {
namespace {

constexpr const char* line_header =
    "id,rho_m,alpha_rad,var_rho_m2,cov_rho_alpha_m_rad,var_alpha_rad2,start_x_m,start_y_m,end_x_m,end_y_m,"
    "observations";

std::optional<MapLine> parse(const std::string& row) {
    std::vector<std::string> fields(1);
    for (const char c : row) {
        if (c == ',')
            fields.emplace_back();
        else if (c != '\r')
            fields.back() += c;
    }
    if (fields.size() != 11) return std::nullopt;
    MapLine line;
    const auto whole = [](const std::string& text, auto& value) {
        const auto end = std::from_chars(text.data(), text.data() + text.size(), value);
        return end.ec == std::errc() && end.ptr == text.data() + text.size();
    };
    if (!whole(fields[0], line.id) || !whole(fields[10], line.observations)) return std::nullopt;
    std::array<double, 9> v{};
    for (std::size_t i = 0; i < v.size(); ++i) {
        const auto value = number_from_text(fields[i + 1]);
        if (!value) return std::nullopt;
        v[i] = *value;
    }
    line.rho_m = v[0];
    line.alpha_rad = v[1];
    line.covariance << v[2], v[3], v[3], v[4];
    line.start_m = {v[5], v[6]};
    line.end_m = {v[7], v[8]};
    return line;
}

}  // namespace

bool is_finite(const MapLine& line) {
    return std::isfinite(line.rho_m) && std::isfinite(line.alpha_rad) && line.covariance.allFinite() &&
           line.start_m.allFinite() && line.end_m.allFinite();
}

std::size_t write_line_map_csv(const std::filesystem::path& file, const LineMap& lines) {
    OutputFile out(file);
    out.text(line_header).text("\n");
    std::size_t left_out = 0;
    for (const auto& line : lines) {
        if (!is_finite(line)) {
            ++left_out;
            continue;
        }
        out.count(line.id);
        for (const double value :
             {line.rho_m, line.alpha_rad, line.covariance(0, 0), line.covariance(0, 1), line.covariance(1, 1),
              line.start_m.x(), line.start_m.y(), line.end_m.x(), line.end_m.y()})
            out.text(",").number(value);
        out.text(",").integer(line.observations).text("\n");
    }
    out.commit();
    return left_out;
}

LineMap read_line_map_csv(const std::filesystem::path& file) {
    std::ifstream in(file);
    std::string row;
    if (!in || !std::getline(in, row))
        throw CommandError(exit_input_data, "can't read the line map " + file.string() +
                                                ": it is missing or empty; give a map.lines.csv");
    if (!row.empty() && row.back() == '\r') row.pop_back();
    if (row != line_header)
        throw CommandError(exit_input_data, file.string() +
                                                ":1: is not the header of a line map, which is \"" +
                                                std::string(line_header) + "\"; give a map.lines.csv");
    LineMap lines;
    for (std::size_t number = 2; std::getline(in, row); ++number) {
        if (row.empty()) continue;
        const auto line = parse(row);
        if (!line)
            throw CommandError(exit_input_data,
                               file.string() + ":" + std::to_string(number) +
                                   ": is not a row of the eleven numbers of a line; give a map.lines.csv");
        lines.push_back(*line);
    }
    return lines;
}

}  // namespace loopline
