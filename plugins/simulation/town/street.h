/// Lines on the plan that a town grows along, and how far places are from them.
#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include "simulation/mesh/solids.h"

namespace loopline::simulation {

/// A line from point to point, map frame.
class Street {
 public:
    Street() = default;
    /// Points in one place are one.
    explicit Street(const std::vector<Eigen::Vector2d>& points_m);

    bool empty() const { return points_m_.size() < 2; }
    double length_m() const { return ways_m_.empty() ? 0 : ways_m_.back(); }
    /// After `way_m`, x ahead; straight on before its beginning and after its end. Headings are those over a
    /// few metres, so that what is placed beside a bend does not jump.
    Pose2 at(double way_m) const;

 private:
    Eigen::Vector2d place_m(double way_m) const;

    std::vector<Eigen::Vector2d> points_m_;
    std::vector<double> ways_m_;  ///< from the first point to each
};

/// Where nothing may stand.
class StreetIndex {
 public:
    void add(const Street& street);
    /// No more than `most_m` of it is looked for.
    double distance_m(const Eigen::Vector2d& place_m, double most_m) const;
    /// Whether the whole rectangle is at least so far away.
    bool is_clear(const Footprint& footprint, double clearance_m) const;

 private:
    static constexpr double cell_m = 8;
    template <class Visit>
    void visit_near(const Eigen::Vector2d& place_m, double reach_m, const Visit& visit) const;

    std::unordered_map<std::int64_t, std::vector<Eigen::Vector2d>> points_of_cell_;
};

/// Ground that is taken already.
class Lots {
 public:
    bool is_free(const Footprint& footprint) const;
    void take(const Footprint& footprint);
    const std::vector<Footprint>& taken() const { return taken_; }

 private:
    static constexpr double cell_m = 16;
    template <class Visit>
    static void visit_cells(const Footprint& footprint, const Visit& visit);

    std::vector<Footprint> taken_;
    std::unordered_map<std::int64_t, std::vector<std::size_t>> of_cell_;
};

}  // namespace loopline::simulation
