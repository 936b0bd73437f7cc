/// How far a finished map may lie off its place, as the path that it was drawn by knows of itself.
#pragma once

#include <filesystem>
#include <vector>

#include "api/pose3.h"

namespace loopline::cloud_localisation {

/// What a run writes beside its map: poses and, line by line, their covariances.
struct PathFiles {
    std::filesystem::path trajectory, covariance;
};

class MapUncertainty {
 public:
    /// Of a map of which nothing is known.
    MapUncertainty() = default;
    /// Throws std::runtime_error with a sentence if the files do not tell what they should.
    explicit MapUncertainty(const PathFiles& files);

    bool is_known() const { return !poses_.empty(); }
    /// Of (shift, turn) of what is seen from this place, along the map's axes, about it: the nearest pose's,
    /// carried there.
    Matrix6d at(const Eigen::Vector3d& p_map_m) const;

 private:
    struct Pose {
        Eigen::Vector3d p_map_m;
        Matrix6d covariance;
    };
    std::vector<Pose> poses_;  ///< some metres apart
};

}  // namespace loopline::cloud_localisation
