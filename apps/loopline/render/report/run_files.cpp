/// Readers that never refuse.
#include "render/report/run_files.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>

#include "api/parameters.h"
#include "commands/command.h"

namespace loopline {
namespace {

namespace fs = std::filesystem;

std::string whole_file(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

nlohmann::ordered_json object_from(const fs::path& file) {
    constexpr bool with_exceptions = false;
    auto json = nlohmann::ordered_json::parse(whole_file(file), nullptr, with_exceptions);
    return json.is_object() ? json : nlohmann::ordered_json::object();
}

std::vector<StampedPose> poses_from(const fs::path& file) {
    try {
        return fs::exists(file) ? read_tum(file) : std::vector<StampedPose>();
    } catch (const CommandError&) {
        return {};
    }
}

std::vector<std::string> cells_of(const std::string& line) {
    std::vector<std::string> cells;
    std::istringstream in(line);
    for (std::string cell; std::getline(in, cell, ',');) cells.push_back(cell);
    return cells;
}

/// Columns are found by their names, so that one more does no harm.
std::vector<Sigma> sigmas_from(const fs::path& file) {
    std::ifstream in(file);
    std::string line;
    if (!std::getline(in, line)) return {};
    const auto names = cells_of(line);
    const auto column = [&](const std::string& name) {
        return static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
    };
    const std::size_t columns[] = {column("cov_x_x_m2"), column("cov_y_y_m2"), column("cov_yaw_yaw_rad2")};
    std::vector<Sigma> sigmas;
    while (std::getline(in, line)) {
        const auto cells = cells_of(line);
        const auto stamp_ns = cells.empty() ? std::nullopt : stamp_from_seconds_text(cells[0]);
        double deviation[3];
        bool is_whole = stamp_ns.has_value();
        for (int i = 0; i < 3 && is_whole; ++i) {
            const auto variance =
                columns[i] < cells.size() ? number_from_text(cells[columns[i]]) : std::nullopt;
            is_whole = variance && *variance >= 0;
            if (is_whole) deviation[i] = std::sqrt(*variance);
        }
        if (is_whole) sigmas.push_back({*stamp_ns, deviation[0], deviation[1], deviation[2]});
    }
    return sigmas;
}

std::vector<RunFile> files_below(const fs::path& folder) {
    std::vector<RunFile> files;
    std::error_code error;
    for (const auto& entry : fs::recursive_directory_iterator(folder, error)) {
        if (!entry.is_regular_file(error)) continue;
        const std::string path = entry.path().lexically_relative(folder).generic_string();
        const std::string name = entry.path().filename().string();
        // Gone as soon as the run has come to its end.
        if (path == "checkpoint.bin" || path.rfind("scratch/", 0) == 0) continue;
        if (path != "report.html" && name.front() != '.') files.push_back({path, entry.file_size(error)});
    }
    std::sort(files.begin(), files.end(), [](const RunFile& a, const RunFile& b) {
        // Files of the run itself before those in folders.
        const bool a_inside = a.path.find('/') != std::string::npos,
                   b_inside = b.path.find('/') != std::string::npos;
        return a_inside != b_inside ? b_inside : a.path < b.path;
    });
    return files;
}

}  // namespace

RunFiles read_run_files(const fs::path& folder) {
    RunFiles run;
    run.folder = folder;
    run.metrics = object_from(folder / "metrics.json");
    run.manifest = object_from(folder / "manifest.json");
    run.estimate = poses_from(folder / "trajectory.tum");
    run.odometry = poses_from(folder / "odometry.tum");
    run.sigmas = sigmas_from(folder / "covariance.csv");
    run.config_ini = whole_file(folder / "config.ini");
    run.feature_points_table = whole_file(folder / "table1.md");
    run.files = files_below(folder);
    return run;
}

}  // namespace loopline
