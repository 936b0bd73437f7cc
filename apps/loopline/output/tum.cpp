#include "output/tum.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <optional>
#include <string_view>

#include "commands/command.h"
#include "output/output_file.h"

namespace loopline {
namespace {

std::optional<double> finite_number(const char* first, const char* last) {
    if (first != last && *first == '+') ++first;
    double value = 0;
    const auto end = std::from_chars(first, last, value);
    if (end.ec != std::errc() || end.ptr != last || !std::isfinite(value)) return std::nullopt;
    return value;
}

/// Decimal text digit by digit; a stamp written with an exponent through a double.
std::optional<StampNs> stamp_from_word(std::string_view word) {
    if (const auto stamp_ns = stamp_from_seconds_text(word)) return stamp_ns;
    const auto seconds = finite_number(word.data(), word.data() + word.size());
    if (!seconds || std::abs(*seconds) > 9e9) return std::nullopt;
    return static_cast<StampNs>(std::llround(*seconds * 1e9));
}

/// The words of a line, which they point into; the list is used again for the next line.
void words_of(const std::string& line, std::vector<std::string_view>& words) {
    const auto is_blank = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
    words.clear();
    const char* first = nullptr;  // of the word that stands open
    for (const char& c : line) {
        if (is_blank(c) == (first == nullptr)) continue;
        if (first != nullptr) words.emplace_back(first, static_cast<std::size_t>(&c - first));
        first = first == nullptr ? &c : nullptr;
    }
    if (first != nullptr)
        words.emplace_back(first, static_cast<std::size_t>(line.data() + line.size() - first));
}

/// The pose of a line, or what is wrong with it.
std::optional<StampedPose> parse(const std::vector<std::string_view>& words, std::string& problem) {
    if (words.size() != 8) {
        problem =
            "has " + std::to_string(words.size()) + " columns instead of the 8 of \"t x y z qx qy qz qw\"";
        return std::nullopt;
    }
    const auto stamp_ns = stamp_from_word(words[0]);
    if (!stamp_ns) {
        problem = "has no time in its first column: \"" + std::string(words[0]) + "\"";
        return std::nullopt;
    }
    std::array<double, 7> v{};
    for (std::size_t i = 0; i < v.size(); ++i) {
        const auto value = finite_number(words[i + 1].data(), words[i + 1].data() + words[i + 1].size());
        if (!value) {
            problem = "has a column that is not a finite number: \"" + std::string(words[i + 1]) + "\"";
            return std::nullopt;
        }
        v[i] = *value;
    }
    Eigen::Quaterniond rotation(v[6], v[3], v[4], v[5]);
    const double norm = rotation.norm();
    if (norm < 0.9 || norm > 1.1) {
        problem = "has a quaternion of length " + std::to_string(norm) + " instead of 1";
        return std::nullopt;
    }
    // What is a unit quaternion to the last digits stays as it was written.
    if (std::abs(norm - 1) > 1e-12) rotation.coeffs() /= norm;
    return StampedPose{*stamp_ns, Pose3({v[0], v[1], v[2]}, rotation)};
}

}  // namespace

std::size_t write_tum(const std::filesystem::path& file, const Trajectory& trajectory, Estimate estimate) {
    OutputFile out(file);
    out.text("# t_s x_m y_m z_m qx qy qz qw (T_map_base)\n");
    std::size_t left_out = 0;
    const std::size_t first = estimate == Estimate::online ? trajectory.known_from() : 0;
    for (std::size_t i = first; i < trajectory.size(); ++i) {
        const TrajectoryEntry entry = trajectory[i];
        const Pose3 pose = estimate == Estimate::latest ? entry.T_map_base : trajectory.T_map_base_online(i);
        if (!pose.translation_m.allFinite() || !pose.rotation.coeffs().allFinite()) {
            ++left_out;
            continue;
        }
        out.seconds(entry.stamp_ns);
        for (const double value : pose.translation_m) out.character(' ').number(value);
        for (const double value : pose.rotation.coeffs()) out.character(' ').number(value);  // x y z w
        out.character('\n');
    }
    out.commit();
    return left_out;
}

std::vector<StampedPose> read_tum(const std::filesystem::path& file) {
    std::vector<StampedPose> poses;
    read_tum(file, [&poses](const StampedPose& pose) { poses.push_back(pose); });
    return poses;
}

void read_tum(const std::filesystem::path& file, const std::function<void(const StampedPose&)>& take) {
    std::ifstream in(file);
    if (!in || !std::filesystem::is_regular_file(file))
        throw CommandError(exit_input_data, "can't read the trajectory " + file.string() +
                                                ": there is no such file; give one in TUM format");
    std::string line, problem;
    std::vector<std::string_view> words;
    for (std::size_t number = 1; std::getline(in, line); ++number) {
        words_of(line, words);
        if (words.empty() || words[0][0] == '#') continue;
        const auto pose = parse(words, problem);
        if (!pose)
            throw CommandError(exit_input_data, file.string() + ":" + std::to_string(number) + ": the line " +
                                                    problem + "; give a trajectory in TUM format");
        take(*pose);
    }
}

}  // namespace loopline
