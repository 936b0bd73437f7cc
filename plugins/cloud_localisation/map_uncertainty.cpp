#include "cloud_localisation/map_uncertainty.h"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <stdexcept>
#include <string>

#include "inertial/pose_error.h"

namespace loopline::cloud_localisation {
namespace {

constexpr double poses_apart_m = 2;  // of which poses are kept

/// The numbers of a line; false if there are others than so many.
bool numbers_of(const std::string& line, char separator, std::vector<double>& numbers, std::size_t count) {
    numbers.clear();
    for (const char* at = line.c_str(); *at != '\0';) {
        char* end = nullptr;
        numbers.push_back(std::strtod(at, &end));
        if (end == at) return false;
        at = *end == separator ? end + 1 : end;
        if (*end != separator && *end != '\0' && *end != '\r') return false;
        if (*end == '\r') break;
    }
    return numbers.size() == count;
}

}  // namespace

MapUncertainty::MapUncertainty(const PathFiles& files) {
    std::ifstream trajectory(files.trajectory), covariance(files.covariance);
    std::string pose_line, covariance_line;
    std::vector<double> pose, variances;
    std::getline(covariance, covariance_line);  // the header
    std::size_t lines = 0;
    while (std::getline(trajectory, pose_line)) {
        if (pose_line.empty() || pose_line.front() == '#') continue;
        ++lines;
        constexpr double same_stamp_s = 1e-3;
        if (!std::getline(covariance, covariance_line) || !numbers_of(pose_line, ' ', pose, 8) ||
            !numbers_of(covariance_line, ',', variances, 37) ||
            !(std::abs(pose[0] - variances[0]) < same_stamp_s))
            throw std::runtime_error(files.covariance.string() + " does not fit " +
                                     files.trajectory.string() + " from pose " + std::to_string(lines) +
                                     " on; take both from the run that made the map, or neither");
        const Eigen::Vector3d p_map_m(pose[1], pose[2], pose[3]);
        if (!poses_.empty() && (p_map_m - poses_.back().p_map_m).norm() < poses_apart_m) continue;
        poses_.push_back({p_map_m, Eigen::Map<const Matrix6d>(variances.data() + 1)});
    }
}

Matrix6d MapUncertainty::at(const Eigen::Vector3d& p_map_m) const {
    if (poses_.empty()) return Matrix6d::Zero();
    const auto nearest = std::min_element(poses_.begin(), poses_.end(), [&](const Pose& a, const Pose& b) {
        return (a.p_map_m - p_map_m).squaredNorm() < (b.p_map_m - p_map_m).squaredNorm();
    });
    const Matrix6d F = inertial::carried_along(p_map_m - nearest->p_map_m);
    return propagated(F, nearest->covariance);
}

}  // namespace loopline::cloud_localisation
