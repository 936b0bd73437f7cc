#include "simulation/scenario.h"

#include <algorithm>
#include <filesystem>
#include <stdexcept>

#include "simulation/cart_path.h"
#include "simulation/clutter.h"
#include "simulation/town/spline_ground.h"
#include "simulation/uneven_floor.h"

namespace loopline::simulation {
namespace {

/// A cart is not turned on the spot.
constexpr int sharpest_turn_deg = 150;

bool can_be_pushed_along(const Waypoints& route) {
    return CartPath::sharpest_turn_rad(route) <= sharpest_turn_deg * M_PI / 180;
}

/// The route so many times in a row; the first waypoint of a lap is the last of the one before.
Waypoints repeated(const Waypoints& route, int laps) {
    Waypoints all = route;
    for (int lap = 1; lap < laps; ++lap) all.insert(all.end(), route.begin() + 1, route.end());
    return all;
}

}  // namespace

Waypoints Scenario::drawn_route() const {
    Waypoints route;
    for (const Row& row : waypoints) route.emplace_back(row[0], row[1]);
    return route;
}

void Scenario::check_route(std::vector<ScenarioProblem>& problems) const {
    const Waypoints route = drawn_route();
    if (laps > 1 && (route.front() - route.back()).norm() > 0.01)
        problems.push_back({"route", "laps", 0, "needs a last waypoint_m that is the first one"});
    if (driving == Driving::pushed && !can_be_pushed_along(repeated(route, std::min(laps, 2))))
        problems.push_back({"route", "drive", 0,
                            "= pushed can't follow a route that turns back by more than " +
                                std::to_string(sharpest_turn_deg) + " degrees at a waypoint_m"});
}

void Scenario::check_plan(std::vector<ScenarioProblem>& problems) const {
    std::vector<PlanProblem> plan_problems;
    build_world(plan, plan_problems);
    for (const auto& p : plan_problems) problems.push_back({"world", p.key, p.row, p.sentence});
    const bool has_plan =
        !plan.walls.empty() || !plan.boxes.empty() || !plan.partitions.empty() || !plan.clutter.empty();
    if (generator == Generator::none) return;
    if (generator == Generator::town && has_plan)
        problems.push_back(
            {"world", "generator", 0,
             "draws a town by itself; remove wall_m, box_m, partition_m and clutter_m, or set it "
             "to none"});
    if (generator != Generator::town && (has_plan || !waypoints.empty()))
        problems.push_back(
            {"world", "generator", 0,
             "draws walls and route by itself; remove wall_m, box_m, partition_m, clutter_m and "
             "waypoint_m, or set it to none"});
}

void Scenario::check_path(std::vector<ScenarioProblem>& problems) const {
    if (generator != Generator::town) {
        if (!path.sequence.empty())
            problems.push_back({"path", "sequence", 0, "is for [world] generator = town"});
        return;
    }
    if (path.sequence.empty()) {
        if (driving != Driving::pushed) problems.push_back({"route", "drive", 0, "must be pushed in a town"});
        return;
    }
    if (!waypoints.empty())
        problems.push_back({"path", "sequence", 0, "gives the route; remove waypoint_m, or the sequence"});
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(path.file(), ignored))
        problems.push_back({"path", "sequence", 0,
                            "= " + path.sequence + " has no file " + path.file() +
                                "; set [path] folder to that of KITTI's poses"});
}

std::vector<ScenarioProblem> Scenario::check() const {
    std::vector<ScenarioProblem> problems;
    check_plan(problems);
    check_path(problems);
    if (!has_waypoints() && laps > 1)
        problems.push_back(
            {"route", "laps", 0, "is for routes that are drawn; a generator's does not end at its start"});
    if (has_waypoints() && waypoints.size() < 2)
        problems.push_back({"route", "", 0, "needs two waypoint_m at least"});
    for (std::size_t i = 1; has_waypoints() && i < waypoints.size(); ++i)
        if (std::hypot(waypoints[i][0] - waypoints[i - 1][0], waypoints[i][1] - waypoints[i - 1][1]) < 0.1)
            problems.push_back({"route", "waypoint_m", i, "is less than 0.1 m from the one before it"});
    if (has_waypoints() && waypoints.size() >= 2) check_route(problems);
    if (vehicle.turn_inner_mps >= vehicle.turn_outer_mps)
        problems.push_back(
            {"vehicle", "turn_inner_mps", 0, "is not below turn_outer_mps, so there would be no turn"});
    if (town.least_storeys > town.storeys)
        problems.push_back({"town", "least_storeys", 0, "is above storeys"});
    if (drive.control_s < drive.step_s)
        problems.push_back({"simulation", "control_s", 0, "is shorter than step_s"});
    return problems;
}

namespace {

GeneratedPlan make_plan(const Scenario& s) {
    if (s.generator == Generator::office) return make_office(s.office, s.plan.height_m, s.seed);
    if (s.generator == Generator::campus) return make_campus(s.campus, s.seed);
    GeneratedPlan plan;
    std::vector<PlanProblem> none;
    if (s.generator == Generator::town) {
        plan.route = s.drawn_route();
        return plan;
    }
    plan.world = build_world(s.plan, none);
    plan.route = s.drawn_route();
    add_clutter(plan.world, s.plan.clutter, plan.route, s.plan.clutter_clear_m, s.seed);
    return plan;
}

std::optional<Drive> make_drive(const Scenario& s, const Waypoints& route) {
    const Waypoints all = repeated(route, s.laps);
    if (s.driving == Driving::steered) return drive_route(all, s.drive, s.driver, s.vehicle, s.seed);
    if (!can_be_pushed_along(all))
        throw std::runtime_error("a cart can't be pushed along this route, which turns back on itself");
    return push_along(all, s.push, s.drive, s.vehicle, s.seed);
}

Drive arrived_drive(const Scenario& s, const Waypoints& route) {
    auto drive = make_drive(s, route);
    if (!drive)
        throw std::runtime_error("the vehicle does not arrive within " + number_text(s.drive.longest_s) +
                                 " s; look at [route] and [vehicle], or raise [simulation] longest_s");
    return std::move(*drive);
}

Street street_of(const Waypoints& route, const PushSettings& push) {
    const CartPath path(route, push.corner_radius_m);
    std::vector<Eigen::Vector2d> points_m;
    const int pieces = std::max(1, static_cast<int>(path.length_m()));
    for (int i = 0; i <= pieces; ++i)
        points_m.push_back(path.at(path.length_m() * i / pieces).T_world_path.translation());
    return Street(points_m);
}

std::uint64_t seed_of_town(const Scenario& s) {
    return s.town_seed != 0 ? s.town_seed : s.seed;
}

/// A town along waypoints, on ground that is drawn.
void make_drawn_landscape(const Scenario& s, const Waypoints& route, const Pose2& T_map_world, Scene& scene) {
    Landscape& landscape = *scene.landscape;
    landscape.ground = std::make_unique<Terrain>(s.terrain, T_map_world, seed_of_town(s));
    landscape.driven = street_of(repeated(route, s.laps), s.push);
    landscape.town = grow_town(street_of(route, s.push), landscape.driven, *landscape.ground, s.town,
                               {seed_of_town(s), s.seed});
    scene.drive.motion.put_on(*landscape.ground);
    roll_wheels_uphill(scene.drive, s.vehicle, s.push.slip_turn, s.seed);
}

/// A town along a recorded path, on ground that passes below it.
void make_recorded_landscape(const Scenario& s, Scene& scene) {
    Landscape& landscape = *scene.landscape;
    const std::vector<Pose3> poses = s.path.read();
    std::vector<Eigen::Vector2d> places_m;
    std::vector<Eigen::Vector3d> ground_m;
    for (const Pose3& T_map_base : poses) {
        places_m.push_back(T_map_base.translation_m.head<2>());
        for (const double left_m : {-1.5, 0.0, 1.5})
            ground_m.push_back(T_map_base * Eigen::Vector3d(0, left_m, -s.path.camera_height_m));
    }
    landscape.ground = std::make_unique<SplineGround>(ground_m, s.town.reach_m);
    landscape.driven = Street(places_m);
    landscape.town =
        grow_town(landscape.driven, landscape.driven, *landscape.ground, s.town, {seed_of_town(s), s.seed});
    scene.drive.motion =
        motion_through(poses, s.path.rate_hz, static_cast<StampNs>(std::llround(s.drive.step_s * 1e9)));
    roll_wheels_uphill(scene.drive, s.vehicle, s.push.slip_turn, s.seed);
}

}  // namespace

std::unique_ptr<Scene> make_scene(const Scenario& s) {
    auto scene = std::make_unique<Scene>();
    const bool recorded = s.generator == Generator::town && !s.path.sequence.empty();
    if (s.generator == Generator::town) scene->landscape = std::make_unique<Landscape>();
    if (recorded) {
        make_recorded_landscape(s, *scene);
    } else {
        GeneratedPlan plan = make_plan(s);
        // The map frame is the first pose.
        const Pose2 T_map_world = Driver(plan.route, s.driver, s.vehicle).start().inverse();
        for (auto& waypoint_m : plan.route) waypoint_m = T_map_world * waypoint_m;
        scene->world = transformed(T_map_world, std::move(plan.world));
        for (Walker walker : plan.walkers) {
            walker.from_m = T_map_world * walker.from_m;
            walker.to_m = T_map_world * walker.to_m;
            scene->walkers.push_back(walker);
        }
        scene->drive = arrived_drive(s, plan.route);
        if (s.sigma_tilt_rad > 0) scene->drive.motion.put_on(UnevenFloor(s.sigma_tilt_rad, s.seed));
        if (scene->landscape) make_drawn_landscape(s, plan.route, T_map_world, *scene);
    }
    if (scene->landscape) {
        Landscape& l = *scene->landscape;
        l.traffic = Traffic(l.driven, scene->drive, *l.ground, l.town.lots, s.traffic, s.seed);
    }
    scene->vehicle = s.vehicle;
    scene->start_ns = static_cast<StampNs>(std::llround(s.start_utc_s * 1e7)) * 100;
    scene->seed = s.seed;
    scene->caster = std::make_unique<RayCaster>(scene->world);
    return scene;
}

}  // namespace loopline::simulation
