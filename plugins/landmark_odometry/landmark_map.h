/// Landmarks on the plan, by sightings from poses that are known: what was seen at one place is one.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <map>
#include <utility>
#include <vector>

namespace loopline::landmark_odometry {

struct MappedLandmark {
    Eigen::Vector2d p_map_m = Eigen::Vector2d::Zero();  ///< weighted mean of its sightings
    int sightings = 0;
};

class LandmarkMap {
 public:
    /// Sightings nearer to a landmark than `join_m` are of it.
    explicit LandmarkMap(double join_m) : join_m_(join_m) {}

    void add(const Eigen::Vector2d& p_map_m, const Eigen::Matrix2d& covariance_m2);
    /// Seen so often at least, in the order in which they were first seen; those that have drawn together are
    /// one.
    std::vector<MappedLandmark> landmarks(int least_sightings) const;

 private:
    struct Sum {
        Eigen::Matrix2d information = Eigen::Matrix2d::Zero();
        Eigen::Vector2d weighted = Eigen::Vector2d::Zero();
        int sightings = 0;

        Eigen::Vector2d mean() const;
    };
    using Cell = std::pair<int, int>;
    Cell cell_of(const Eigen::Vector2d& p_map_m) const;

    double join_m_;
    std::vector<Sum> sums_;
    std::map<Cell, std::vector<std::size_t>> begun_in_;  ///< those whose first sighting was there
};

}  // namespace loopline::landmark_odometry
