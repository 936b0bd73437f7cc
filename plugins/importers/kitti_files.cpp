#include "importers/kitti_files.h"

#include <algorithm>
#include <ctime>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include "api/parameters.h"

namespace loopline::kitti {

namespace fs = std::filesystem;

namespace {

[[noreturn]] void refuse(const fs::path& file, const std::string& what) {
    throw std::runtime_error(file.string() + " " + what);
}

std::vector<fs::path> files_of(const fs::path& folder, const std::string& extension) {
    std::vector<fs::path> files;
    std::error_code error;
    for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error))
        if (entry->path().extension() == extension && entry->is_regular_file())
            files.push_back(entry->path());
    std::sort(files.begin(), files.end());
    return files;
}

std::vector<std::string> lines_of(const fs::path& file) {
    std::ifstream stream(file);
    if (!stream) refuse(file, "can't be read");
    std::vector<std::string> lines;
    for (std::string line; std::getline(stream, line);) {
        while (!line.empty() && std::isspace(static_cast<unsigned char>(line.back()))) line.pop_back();
        if (!line.empty()) lines.push_back(line);
    }
    return lines;
}

/// "2011-09-26 13:02:25.964389445".
std::optional<StampNs> time_of_date(const std::string& text) {
    std::tm date{};
    const char* const rest = strptime(text.c_str(), "%Y-%m-%d %H:%M:%S", &date);
    if (rest == nullptr) return std::nullopt;
    const auto part = stamp_from_seconds_text(*rest == '.' ? "0" + std::string(rest).substr(0, 10) : "0");
    if (!part) return std::nullopt;
    return static_cast<StampNs>(timegm(&date)) * 1'000'000'000 + *part;
}

std::optional<StampNs> time_of_line(const std::string& line) {
    const std::size_t comma = line.rfind(',');
    const std::string text = comma == std::string::npos ? line : line.substr(comma + 1);
    if (text.find(':') != std::string::npos) return time_of_date(text);
    if (const auto exact = stamp_from_seconds_text(text)) return exact;
    if (const auto seconds = number_from_text(text))
        return static_cast<StampNs>(std::llround(*seconds * 1e9));
    return std::nullopt;
}

std::optional<Pose3> pose_of(const std::string& row) {
    std::istringstream words(row);
    Eigen::Matrix<double, 3, 4, Eigen::RowMajor> matrix;
    for (int i = 0; i < 12; ++i) words >> matrix.data()[i];
    if (!words || !matrix.allFinite()) return std::nullopt;
    const Eigen::Matrix3d rotation = matrix.leftCols<3>();
    return Pose3(matrix.col(3), Eigen::Quaterniond(rotation).normalized());
}

}  // namespace

std::vector<fs::path> bin_files(const fs::path& folder) {
    for (const char* below : {"", "velodyne", "velodyne_points/data", "data"})
        if (auto files = files_of(folder / below, ".bin"); !files.empty()) return files;
    return {};
}

std::vector<fs::path> oxts_files(const fs::path& folder) {
    for (const char* below : {"", "data"})
        if (auto files = files_of(folder / below, ".txt"); files.size() > 1) return files;
    return {};
}

std::vector<BinPoint> read_bin(const fs::path& file) {
    std::error_code error;
    const auto size = fs::file_size(file, error);
    if (error) refuse(file, "can't be read");
    if (size % sizeof(BinPoint) != 0)
        refuse(file, "is damaged: it does not hold four numbers of 4 bytes for each point");
    std::vector<BinPoint> points(size / sizeof(BinPoint));
    std::ifstream stream(file, std::ios::binary);
    stream.read(reinterpret_cast<char*>(points.data()), static_cast<std::streamsize>(size));
    if (!stream) refuse(file, "can't be read");
    return points;
}

std::vector<StampNs> read_times(const fs::path& file) {
    std::vector<StampNs> times_ns;
    bool heading = true;
    for (const std::string& line : lines_of(file)) {
        const auto time_ns = time_of_line(line);
        if (!time_ns && !heading) refuse(file, "has a line that is no time: " + line);
        heading = heading && !time_ns;
        if (time_ns) times_ns.push_back(*time_ns);
    }
    return times_ns;
}

std::vector<Pose3> read_lidar_poses(const fs::path& file, const Pose3& T_camera_lidar) {
    std::vector<Pose3> poses;
    Pose3 T_first_world;
    for (const std::string& line : lines_of(file)) {
        const auto T_world_camera = pose_of(line);
        if (!T_world_camera)
            refuse(file,
                   "has a line that is no row of 12 numbers, number " + std::to_string(poses.size() + 1));
        const Pose3 T_world_lidar = *T_world_camera * T_camera_lidar;
        if (poses.empty()) T_first_world = T_world_lidar.inverse();
        poses.push_back(T_first_world * T_world_lidar);
    }
    return poses;
}

Pose3 read_T_camera_lidar(const fs::path& file) {
    for (const std::string& line : lines_of(file))
        for (const char* key : {"Tr:", "Tr_velo_to_cam:"})
            if (line.rfind(key, 0) == 0)
                if (const auto pose = pose_of(line.substr(std::string(key).size()))) return *pose;
    refuse(file, "has no line \"Tr:\" with 12 numbers");
}

Pose3 axes_camera_lidar() {
    Eigen::Matrix3d R_camera_lidar;
    R_camera_lidar << 0, -1, 0, 0, 0, -1, 1, 0, 0;
    return {Eigen::Vector3d::Zero(), Eigen::Quaterniond(R_camera_lidar)};
}

Oxts read_oxts(const fs::path& file) {
    const auto lines = lines_of(file);
    std::istringstream words(lines.empty() ? std::string() : lines.front());
    double v[30];
    for (double& value : v) words >> value;
    if (!words) refuse(file, "does not begin with 30 numbers");
    return {v[0], v[1], v[2], {v[11], v[12], v[13]}, {v[17], v[18], v[19]}, static_cast<int>(v[26])};
}

std::optional<fs::path> beside(const fs::path& scans, const std::string& name) {
    std::error_code ignored;
    fs::path folder = fs::absolute(scans);
    for (int up = 0; up < 3; ++up, folder = folder.parent_path())
        if (fs::exists(folder / name, ignored)) return folder / name;
    return std::nullopt;
}

}  // namespace loopline::kitti
