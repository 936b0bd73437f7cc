#include "simulation/floor_plan.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

namespace loopline::simulation {
namespace {

constexpr double tolerance_m = 1e-3;  ///< drawn by hand, to the millimetre

Eigen::Vector2d left_of(const Eigen::Vector2d& direction) {
    return {-direction.y(), direction.x()};
}

class Builder {
 public:
    Builder(const FloorPlan& plan, std::vector<PlanProblem>& problems) : plan_(plan), problems_(problems) {
        if (plan.ceiling) world_.ceiling_m = plan.height_m;
    }

    World build() {
        for (std::size_t i = 0; i < plan_.walls.size(); ++i) draw_chain(i);
        for (std::size_t i = 0; i < plan_.doors.size(); ++i) set_back("door_m", i, plan_.doors[i]);
        for (std::size_t i = 0; i < plan_.pilasters.size(); ++i)
            set_back("pilaster_m", i, plan_.pilasters[i]);
        for (std::size_t i = 0; i < plan_.partitions.size(); ++i) raise_partition(i);
        for (std::size_t i = 0; i < plan_.boxes.size(); ++i) place_box(i);
        for (std::size_t i = 0; i < plan_.clutter.size(); ++i) check_clutter(i);
        for (std::size_t i = 0; i < plan_.points.size(); ++i) mark_point(i);
        return std::move(world_);
    }

 private:
    void report(const char* key, std::size_t row, const std::string& sentence) {
        problems_.push_back({key, row, sentence});
    }

    void add(const Eigen::Vector2d& from_m, const Eigen::Vector2d& to_m, double bottom_m, double top_m) {
        world_.walls.push_back({from_m, to_m, bottom_m, top_m});
    }

    void draw_chain(std::size_t index) {
        const Row& row = plan_.walls[index];
        for (std::size_t k = 0; k + 3 < row.size(); k += 2) {
            const Eigen::Vector2d from_m(row[k], row[k + 1]), to_m(row[k + 2], row[k + 3]);
            if ((to_m - from_m).norm() < tolerance_m)
                return report("wall_m", index, "has two corners in one place");
            add(from_m, to_m, 0, plan_.height_m);
        }
    }

    /// The wall from floor to ceiling that holds both points.
    std::optional<std::size_t> wall_with(const Eigen::Vector2d& a_m, const Eigen::Vector2d& b_m) const {
        for (std::size_t i = 0; i < world_.walls.size(); ++i) {
            const Wall& wall = world_.walls[i];
            if (wall.bottom_m != 0 || wall.top_m != plan_.height_m) continue;
            if (distance_from(wall, a_m) < tolerance_m && distance_from(wall, b_m) < tolerance_m) return i;
        }
        return std::nullopt;
    }

    static double distance_from(const Wall& wall, const Eigen::Vector2d& point_m) {
        const Eigen::Vector2d way_m = wall.to_m - wall.from_m;
        const double part = (point_m - wall.from_m).dot(way_m) / way_m.squaredNorm();
        return (wall.from_m + std::clamp(part, 0.0, 1.0) * way_m - point_m).norm();
    }

    /// Cuts a wall between two of its points and leads it around by `depth`.
    void set_back(const char* key, std::size_t index, const Row& row) {
        const Eigen::Vector2d a_m(row[0], row[1]), b_m(row[2], row[3]);
        const double width_m = (b_m - a_m).norm();
        if (width_m < tolerance_m) return report(key, index, "is not wider than 1 mm");
        if (std::abs(row[4]) < tolerance_m) return report(key, index, "is not deeper than 1 mm");
        const auto found = wall_with(a_m, b_m);
        if (!found) return report(key, index, "does not lie on one wall, from its first to its second point");
        const Wall cut = world_.walls[*found];
        world_.walls.erase(world_.walls.begin() + static_cast<std::ptrdiff_t>(*found));
        const bool same_way = (b_m - a_m).dot(cut.to_m - cut.from_m) > 0;
        const Eigen::Vector2d &first_m = same_way ? a_m : b_m, &last_m = same_way ? b_m : a_m;
        if ((first_m - cut.from_m).norm() > tolerance_m) add(cut.from_m, first_m, 0, plan_.height_m);
        if ((cut.to_m - last_m).norm() > tolerance_m) add(last_m, cut.to_m, 0, plan_.height_m);

        const Eigen::Vector2d depth_m = row[4] * left_of((b_m - a_m) / width_m);
        add(a_m, a_m + depth_m, 0, plan_.height_m);
        add(a_m + depth_m, b_m + depth_m, 0, plan_.height_m);
        add(b_m + depth_m, b_m, 0, plan_.height_m);
        if (key == std::string("door_m") && plan_.door_height_m < plan_.height_m)
            add(a_m, b_m, plan_.door_height_m, plan_.height_m);  // the lintel
    }

    void raise_partition(std::size_t index) {
        const Row& row = plan_.partitions[index];
        const Eigen::Vector2d a_m(row[0], row[1]), b_m(row[2], row[3]);
        const Eigen::Vector2d way_m = b_m - a_m;
        if (way_m.norm() < tolerance_m || row[4] < tolerance_m)
            return report("partition_m", index, "is not longer and thicker than 1 mm");
        add_box(world_, (a_m + b_m) / 2, way_m.norm(), row[4], std::atan2(way_m.y(), way_m.x()),
                plan_.height_m);
    }

    void check_clutter(std::size_t index) {
        const Row& row = plan_.clutter[index];
        if (row[4] != std::floor(row[4]) || row[4] < 0 || row[4] > 1000)
            report("clutter_m", index, "has a number of pieces that is not whole, from 0 to 1000");
    }

    void place_box(std::size_t index) {
        const Row& row = plan_.boxes[index];
        if (row[2] < tolerance_m || row[3] < tolerance_m || row[5] < tolerance_m)
            return report("box_m", index, "has a side or a height of less than 1 mm");
        add_box(world_, {row[0], row[1]}, row[2], row[3], row[4] * M_PI / 180, row[5]);
    }

    void mark_point(std::size_t index) {
        const Row& row = plan_.points[index];
        const Eigen::Vector2d point_m(row[1], row[2]);
        if (row[0] != std::floor(row[0]) || std::abs(row[0]) > 1e9)
            return report("point_m", index, "has a number that is not whole");
        const int number = static_cast<int>(row[0]);
        if (!numbers_.insert(number).second)
            return report("point_m", index, "has a number that another point has");
        bool is_corner = false;
        for (const Wall& wall : world_.walls)
            is_corner = is_corner || (wall.from_m - point_m).norm() < tolerance_m ||
                        (wall.to_m - point_m).norm() < tolerance_m;
        if (!is_corner) return report("point_m", index, "is not the corner of a wall, a door or a pilaster");
        world_.points.push_back({number, point_m});
    }

    const FloorPlan& plan_;
    std::vector<PlanProblem>& problems_;
    World world_;
    std::set<int> numbers_;
};

}  // namespace

World build_world(const FloorPlan& plan, std::vector<PlanProblem>& problems) {
    return Builder(plan, problems).build();
}

void add_box(World& world, const Eigen::Vector2d& centre_m, double length_m, double width_m, double angle_rad,
             double height_m) {
    const Pose2 T_world_box{centre_m.x(), centre_m.y(), angle_rad};
    const double l = length_m / 2, w = width_m / 2;
    const Eigen::Vector2d corners[] = {
        T_world_box * Eigen::Vector2d(l, w), T_world_box * Eigen::Vector2d(-l, w),
        T_world_box * Eigen::Vector2d(-l, -w), T_world_box * Eigen::Vector2d(l, -w)};
    for (int i = 0; i < 4; ++i) world.walls.push_back({corners[i], corners[(i + 1) % 4], 0, height_m});
}

}  // namespace loopline::simulation
