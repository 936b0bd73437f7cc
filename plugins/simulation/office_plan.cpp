#include "simulation/office_plan.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "simulation/floor_plan.h"
#include "simulation/random_stream.h"
#include "simulation/segment.h"

namespace loopline::simulation {
namespace {

constexpr double door_height_m = 2.1;
constexpr double free_way_m = 0.65;  ///< to each side of the route

/// A room on one side of a corridor that runs along x: its inside is x0 .. x1 by `depth` from the corridor's
/// wall at `wall_y` on, to the side `side` (+1 or -1).
struct Room {
    double x0, x1, wall_y, side, depth, door_x;
    bool visited = false, open = false;
};

class Office {
 public:
    Office(const OfficeSettings& settings, double height_m, std::uint64_t seed)
        : s_(settings), height_m_(height_m), random_(seed, "office") {
        plan_.world.ceiling_m = height_m;
    }

    GeneratedPlan make() {
        lay_out_rooms();
        choose_visits();
        plan_route();
        for (const Room& room : rooms_) build_room(room);
        build_corridor_ends();
        for (const Room& room : rooms_) furnish(room);
        let_people_in();
        return std::move(plan_);
    }

 private:
    double half() const { return s_.corridor_m / 2; }
    double length() const { return s_.rooms * (s_.room_width_m + s_.wall_m) + s_.wall_m; }
    /// From the middle of the lower corridor to that of the upper one: two rooms back to back.
    double rise() const { return s_.corridor_m + 2 * s_.room_depth_m + 3 * s_.wall_m; }
    double start_x() const { return half(); }  // the corridors across are at x = 0 and at the far end

    /// Four rows: below and above each of the two corridors, in the order of the round.
    void lay_out_rooms() {
        for (const double corridor_y : {0.0, rise()})
            for (const double side : {-1.0, 1.0})
                for (int i = 0; i < s_.rooms; ++i) {
                    const double x0 = start_x() + s_.wall_m + i * (s_.room_width_m + s_.wall_m);
                    Room room{x0, x0 + s_.room_width_m, corridor_y + side * half(), side, s_.room_depth_m, 0};
                    room.door_x = x0 + random_.uniform(s_.door_m, s_.room_width_m - s_.door_m - 1.0);
                    room.open = random_.chance(s_.open_doors);
                    rooms_.push_back(room);
                }
    }

    void choose_visits() {
        const int most = std::min<int>(s_.visits, static_cast<int>(rooms_.size()));
        for (int visits = 0; visits < most;) {
            Room& room = rooms_[static_cast<std::size_t>(random_.index(static_cast<int>(rooms_.size())))];
            if (room.visited) continue;
            room.visited = room.open = true;
            ++visits;
        }
    }

    void add(double x0, double y0, double x1, double y1, double bottom_m = 0, double top_m = 0) {
        plan_.world.walls.push_back({{x0, y0}, {x1, y1}, bottom_m, top_m > 0 ? top_m : height_m_});
    }

    /// In and out again: a loop of right angles inside the room.
    void visit(const Room& room) {
        const double corridor_y = room.wall_y - room.side * half();
        const double near_y =
            room.wall_y + room.side * (s_.wall_m + s_.door_m + free_way_m);  // past the open leaf
        const double far_y = room.wall_y + room.side * (s_.wall_m + std::min(3.5, room.depth - 0.8));
        const double x = room.door_x, beyond_x = x + 1.2;
        for (const auto& corner :
             {Eigen::Vector2d(x, corridor_y), Eigen::Vector2d(x, far_y), Eigen::Vector2d(beyond_x, far_y),
              Eigen::Vector2d(beyond_x, near_y), Eigen::Vector2d(x, near_y), Eigen::Vector2d(x, corridor_y)})
            plan_.route.push_back(corner);
    }

    void plan_route() {
        const double end_x = start_x() + length() + half();
        std::vector<const Room*> there, back;
        for (const Room& room : rooms_)
            if (room.visited) (std::abs(room.wall_y) < rise() / 2 ? there : back).push_back(&room);
        const auto by_door = [](const Room* a, const Room* b) { return a->door_x < b->door_x; };
        std::sort(there.begin(), there.end(), by_door);
        std::sort(back.rbegin(), back.rend(), by_door);
        plan_.route = {{0, 0}};
        for (const Room* room : there) visit(*room);
        plan_.route.emplace_back(end_x, 0);
        plan_.route.emplace_back(end_x, rise());
        for (const Room* room : back) visit(*room);
        plan_.route.emplace_back(0, rise());
        plan_.route.emplace_back(0, 0);
        plan_.route.emplace_back(4, 0);
        remove_short_legs();
    }

    /// Two doors face to face are one corner.
    void remove_short_legs() {
        auto& route = plan_.route;
        for (std::size_t i = 1; i < route.size();)
            if ((route[i] - route[i - 1]).norm() < 0.3)
                route.erase(route.begin() + static_cast<std::ptrdiff_t>(i));
            else
                ++i;
    }

    void build_room(const Room& r) {
        const double inner_y = r.wall_y + r.side * s_.wall_m, back_y = inner_y + r.side * r.depth;
        const double d0 = r.door_x - s_.door_m / 2, d1 = r.door_x + s_.door_m / 2;
        // Corridor's side, with half of the walls to the neighbours; the room's own side; its other walls.
        add(r.x0 - s_.wall_m, r.wall_y, d0, r.wall_y);
        add(d1, r.wall_y, r.x1, r.wall_y);
        add(r.x0, inner_y, d0, inner_y);
        add(d1, inner_y, r.x1, inner_y);
        add(r.x0, inner_y, r.x0, back_y);
        add(r.x1, inner_y, r.x1, back_y);
        add(r.x0, back_y, r.x1, back_y);
        for (const double x : {d0, d1}) add(x, r.wall_y, x, inner_y);
        add(d0, r.wall_y, d1, r.wall_y, door_height_m, height_m_);
        if (r.open)
            add(d1, inner_y, d1, inner_y + r.side * s_.door_m, 0, door_height_m);  // the leaf
        else
            add(d0, r.wall_y + r.side * 0.05, d1, r.wall_y + r.side * 0.05, 0, door_height_m);
    }

    void build_corridor_ends() {
        const double end_x = start_x() + length();
        const double low_y = -half(), high_y = rise() + half();
        // Outer walls of the corridors across, and the block's walls that face them.
        add(-half(), low_y, -half(), high_y);
        add(end_x + s_.corridor_m, low_y, end_x + s_.corridor_m, high_y);
        for (const double x : {start_x(), end_x}) add(x, half(), x, rise() - half());
        // What is left of the walls along the corridors: one wall's thickness, and the corners.
        for (const double y : {low_y, high_y}) {
            add(-half(), y, start_x(), y);
            add(end_x - s_.wall_m, y, end_x + s_.corridor_m, y);
        }
        for (const double y : {half(), rise() - half()}) add(end_x - s_.wall_m, y, end_x, y);
    }

    bool in_the_way(const Eigen::Vector2d& place, double size_m) const {
        for (std::size_t i = 0; i + 1 < plan_.route.size(); ++i)
            if (distance_to_segment_m(place, plan_.route[i], plan_.route[i + 1]) < free_way_m + size_m)
                return true;
        return false;
    }

    /// Boxes anywhere but in the way of the vehicle or of the door.
    void furnish(const Room& r) {
        const double inner_y = r.wall_y + r.side * s_.wall_m;
        const Eigen::Vector2d door(r.door_x, inner_y);
        std::vector<std::pair<Eigen::Vector2d, double>> placed;  // with half their diagonal
        for (int attempt = 0; static_cast<int>(placed.size()) < s_.clutter && attempt < 300; ++attempt) {
            const double length_m = random_.uniform(0.3, 1.6), width_m = random_.uniform(0.3, 0.8);
            const double angle_rad =
                random_.chance(0.7) ? random_.index(2) * M_PI / 2 : random_.uniform(0, M_PI);
            const double top_m = random_.uniform(0.6, 1.9);
            const double size_m = std::hypot(length_m, width_m) / 2;
            const Eigen::Vector2d place(random_.uniform(r.x0 + size_m, r.x1 - size_m),
                                        inner_y + r.side * random_.uniform(size_m, r.depth - size_m));
            if (r.depth < 2 * size_m || (place - door).norm() < s_.door_m + size_m ||
                in_the_way(place, size_m))
                continue;
            const bool overlaps = std::any_of(placed.begin(), placed.end(), [&](const auto& other) {
                return (other.first - place).norm() < other.second + size_m;
            });
            if (overlaps) continue;
            add_box(plan_.world, place, length_m, width_m, angle_rad, top_m);
            placed.emplace_back(place, size_m);
        }
    }

    void let_people_in() {
        const double end_x = start_x() + length() + half();
        for (int i = 0; i < s_.people; ++i) {
            Walker walker;
            walker.speed_mps = random_.uniform(0.4, 1.4);
            walker.phase = random_.uniform();
            walker.radius_m = random_.uniform(0.15, 0.25);
            walker.top_m = random_.uniform(1.5, 1.9);
            const double beside_m = random_.uniform(-0.35, 0.35) * s_.corridor_m;
            if (random_.chance(0.7)) {
                const double y = random_.index(2) * rise() + beside_m;
                walker.from_m = {random_.uniform(0, end_x / 2), y};
                walker.to_m = {random_.uniform(end_x / 2, end_x), y};
            } else {
                const Room& room =
                    rooms_[static_cast<std::size_t>(random_.index(static_cast<int>(rooms_.size())))];
                const double y =
                    room.wall_y + room.side * (s_.wall_m + random_.uniform(1.0, room.depth - 0.5));
                walker.from_m = {room.x0 + 0.4, y};
                walker.to_m = {room.x1 - 0.4, y};
            }
            plan_.walkers.push_back(walker);
        }
    }

    OfficeSettings s_;
    double height_m_;
    RandomStream random_;
    std::vector<Room> rooms_;
    GeneratedPlan plan_;
};

}  // namespace

GeneratedPlan make_office(const OfficeSettings& settings, double height_m, std::uint64_t seed) {
    return Office(settings, height_m, seed).make();
}

}  // namespace loopline::simulation
