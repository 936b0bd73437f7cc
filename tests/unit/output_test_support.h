/// A folder of its own for a test, and small independent readers.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "api/trajectory.h"

namespace output_test {

/// Made anew, removed at the end of the test.
class Folder {
 public:
    Folder() {
        const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
        path_ =
            std::filesystem::temp_directory_path() / ("loopline_" + std::string(test->test_suite_name()) +
                                                      "_" + test->name() + "_" + std::to_string(::getpid()));
        std::filesystem::remove_all(path_);
        std::filesystem::create_directories(path_);
    }
    ~Folder() {
        std::error_code ignored;
        std::filesystem::remove_all(path_, ignored);
    }
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;
    std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
    const std::filesystem::path& path() const { return path_; }

 private:
    std::filesystem::path path_;
};

inline std::string content(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

inline std::vector<std::string> split(const std::string& text, char separator) {
    std::vector<std::string> parts;
    std::istringstream in(text);
    for (std::string part; std::getline(in, part, separator);) parts.push_back(part);
    return parts;
}

/// Spatial poses with full covariances; stamps go backwards once, as in some logs.
inline loopline::Trajectory random_trajectory(std::size_t size, std::uint64_t seed) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    loopline::Trajectory trajectory;
    for (std::size_t i = 0; i < size; ++i) {
        const Eigen::Quaterniond q(normal(random), normal(random), normal(random), normal(random));
        const loopline::Matrix6d root = loopline::Matrix6d::NullaryExpr([&] { return 0.1 * normal(random); });
        const Eigen::Vector3d t(1e3 * normal(random), normal(random), 1e-7 * normal(random));
        const auto stamp_ns =
            static_cast<loopline::StampNs>(1137834225973760001 + 27027027 * (i == 5 ? 3 : i));
        trajectory.append(3 * i, stamp_ns, {t, q.normalized()}, root * root.transpose());
    }
    return trajectory;
}

}  // namespace output_test
