#include "simulation/scenario.h"

namespace loopline::simulation {
namespace {

ParameterTable world_table(FloorPlan& plan, Generator& generator, std::uint64_t& town_seed,
                           double& sigma_tilt_rad) {
    return ParameterTable("world", "Walls, in metres: drawn row by row, or by a generator from the seed.")
        .choice("generator", generator,
                {{"none", Generator::none},
                 {"office", Generator::office},
                 {"campus", Generator::campus},
                 {"town", Generator::town}},
                "Draws walls, route and people by the section of its name; none: the rows here and in "
                "[route] do; town: a landscape along [route] or [path], for the spinning lidar.")
        .seed("town_seed", town_seed,
              "Of a town's houses, trees and hills, so that another drive finds them again, with other cars; "
              "0: "
              "[simulation] seed.")
        .real("height_m", plan.height_m, {0.1, 1000}, "Height of the walls, and of the ceiling.")
        .real("door_height_m", plan.door_height_m, {0.1, 1000}, "Above it, a door's wall goes on.")
        .boolean("ceiling", plan.ceiling, "Whether there is one.")
        .angle(
            "sigma_tilt_deg", sigma_tilt_rad, {0, 5},
            "Standard deviation of the floor's slope in any direction; it tilts and lifts the vehicle, the "
            "same wherever that comes back to.")
        .rows("wall_m", plan.walls, {4, 2}, "x y x y ...", "A chain of walls from corner to corner.")
        .rows("door_m", plan.doors, {5, 0}, "x1 y1 x2 y2 depth",
              "A part of a wall that is set back to the left of the way from its first to its second point.")
        .rows("pilaster_m", plan.pilasters, {5, 0}, "x1 y1 x2 y2 depth",
              "A part of a wall that stands out to the left of the way from its first to its second point.")
        .rows("partition_m", plan.partitions, {5, 0}, "x1 y1 x2 y2 thickness",
              "A wall with two sides, about the line from its first to its second point.")
        .rows("box_m", plan.boxes, {6, 0}, "x y length width turn height",
              "A box on the ground: its middle, its size, and how far it is turned, in degrees.")
        .rows("clutter_m", plan.clutter, {5, 0}, "x0 y0 x1 y1 pieces",
              "Furniture that the seed draws: so many boxes, in the rectangle between two of its corners.")
        .real("clutter_clear_m", plan.clutter_clear_m, {0.4, 100},
              "No piece of it is nearer to the legs of the route.")
        .rows("point_m", plan.points, {3, 0}, "number x y", "A corner that results are compared at.");
}

ParameterTable office_table(OfficeSettings& s) {
    return ParameterTable("office", "Generator: offices around a ring of corridors.")
        .integer("rooms", s.rooms, {1, 200}, "Rooms along a corridor, on each of its sides.")
        .real("room_width_m", s.room_width_m, {3.5, 100}, "Along the corridor.")
        .real("room_depth_m", s.room_depth_m, {3.5, 100}, "Away from it.")
        .real("corridor_m", s.corridor_m, {1, 20}, "Width of the corridors.")
        .real("wall_thickness_m", s.wall_m, {0.05, 1}, "Thickness of the walls.")
        .real("door_width_m", s.door_m, {0.6, 1.2}, "Width of the doors.")
        .real("open_doors", s.open_doors, {0, 1},
              "Part of the doors that are open; those of visited rooms are.")
        .integer("visits", s.visits, {0, 800}, "Rooms that the round leads through.")
        .integer("clutter", s.clutter, {0, 100}, "Pieces of furniture in a room.")
        .integer("people", s.people, {0, 1000}, "People who walk to and fro.");
}

ParameterTable campus_table(CampusSettings& s) {
    return ParameterTable("campus", "Generator: streets between buildings with stepped fronts.")
        .integer("walls", s.walls, {1, 1000000}, "Walls to draw, at least; no two on one line.")
        .integer("columns", s.columns, {1, 1000}, "Buildings along a street.")
        .real("street_m", s.street_m, {4, 100}, "Width of the streets.")
        .real("gap_m", s.gap_m, {1, 100}, "From building to building along a street.")
        .real("building_length_m", s.building_length_m, {2, 1000}, "Along the street.")
        .real("building_depth_m", s.building_depth_m, {6, 1000}, "From street to street.")
        .integer("sections", s.sections, {1, 100}, "Of a front, each set back by itself.")
        .real("step_m", s.step_m, {0.1, 2.5}, "How far a section is set back at most.")
        .angle("turned_deg", s.turned_rad, {0, 15}, "How far a building stands askew at most.")
        .real("wall_height_m", s.height_m, {0.1, 1000}, "Height of the buildings.");
}

ParameterTable town_table(TownSettings& s) {
    return ParameterTable(
               "town",
               "Generator: streets that grow along the way of the vehicle, on the ground of [terrain].")
        .real("built", s.built, {0, 1}, "Part of the fronts along streets that is built up; 0: no houses.")
        .real("setback_m", s.setback_m, {6, 200},
              "From the way to the fronts on its right; to the left is one more lane.")
        .real("setback_spread_m", s.setback_spread_m, {0, 200}, "How much farther back fronts stand at most.")
        .real("front_m", s.front_m, {4, 100}, "Length of a house along the street, about.")
        .integer("storeys", s.storeys, {1, 30}, "Of a house, at most.")
        .integer("least_storeys", s.least_storeys, {1, 30}, "Of a house, at least.")
        .real("side_street_m", s.side_street_m, {0, 10000},
              "Way from one side street to the next, about; 0: none.")
        .real("kerb_m", s.kerb_m, {0, 1}, "Height of pavements; 0: none.")
        .real("parked_per_km", s.parked_per_km, {0, 200},
              "Cars parked on either side; fewer where there is no room.")
        .real("trees_per_km", s.trees_per_km, {0, 1000}, "Trees on either side.")
        .real("bushes_per_km", s.bushes_per_km, {0, 1000}, "Bushes on either side.")
        .real("posts_per_km", s.posts_per_km, {0, 1000}, "Lamp posts and signs on either side.")
        .real("ground_cell_m", s.ground_cell_m, {0.25, 50},
              "The ground is level triangles between points so far apart.")
        .real("reach_m", s.reach_m, {10, 1000}, "There is ground so far from the way.")
        .rows("gallery_m", s.galleries, {4, 0}, "from to width height",
              "A tunnel with pillars over the way, from so many metres after its beginning.")
        .rows("tunnel_m", s.tunnels, {4, 0}, "from to width height",
              "A tunnel of one smooth cross section, with nothing in it.");
}

ParameterTable terrain_table(TerrainSettings& s) {
    return ParameterTable("terrain", "Ground of a town along waypoints; it tilts and lifts the vehicle.")
        .angle("sigma_slope_deg", s.sigma_slope_rad, {0, 20},
               "Standard deviation of the slope of hills in any direction; they are 80 to 400 m long.")
        .angle("sigma_rough_deg", s.sigma_rough_rad, {0, 10}, "The same of waves that are 4 to 30 m long.")
        .rows("ramp_m", s.ramps, {5, 0}, "x1 y1 x2 y2 rise",
              "Ground that rises from its first point to its second, the same across.");
}

ParameterTable traffic_table(TrafficSettings& s) {
    return ParameterTable("traffic", "Cars that move in a town.")
        .real("oncoming_s", s.oncoming_s, {0, 10000},
              "Time from one on the other lane to the next, about; 0: none.")
        .real("oncoming_mps", s.oncoming_mps, {0.5, 60}, "Their speed, about.")
        .real("ahead", s.ahead, {0, 1}, "Part of the time that a car drives ahead of the vehicle.")
        .real("standing_per_km", s.standing_per_km, {0, 200},
              "Cars that stand on either lane from the beginning and drive off when the vehicle comes near.");
}

ParameterTable path_table(RecordedPathSettings& s) {
    return ParameterTable(
               "path",
               "A recorded path for a town to grow along, in place of [route]: poses of KITTI's odometry "
               "benchmark. The vehicle's origin is the camera, on axes that look ahead, left and up.")
        .text("sequence", s.sequence, "Which: 00 is 00.txt in the folder; empty: there is none.")
        .path("folder", s.folder, "Folder of the files.")
        .real("rate_hz", s.rate_hz, {0.1, 1000}, "Poses a second.")
        .real("camera_height_m", s.camera_height_m, {0.1, 10}, "Of the poses above the street.")
        .boolean(
            "level_revisits", s.level_revisits,
            "Whether heights are changed, slowly along the way, until they agree wherever it comes back to a "
            "place; in some sequences they differ by metres.")
        .integer("first", s.first, {0, 1000000},
                 "Number of the first pose that is driven; it becomes the map's frame.")
        .integer("poses", s.poses, {0, 1000000}, "How many are driven; 0: all that follow.");
}

ParameterTable route_table(std::vector<Row>& waypoints, int& laps, Driving& driving, DriverSettings& s) {
    return ParameterTable("route", "Where the vehicle drives, and how well it keeps to that.")
        .choice("drive", driving, {{"steered", Driving::steered}, {"pushed", Driving::pushed}},
                "steered: by the three ways to drive of [vehicle]; pushed: a cart, as [cart] says.")
        .integer("laps", laps, {1, 1000},
                 "How often the route is driven, one after the other; it has to end where it begins.")
        .rows("waypoint_m", waypoints, {2, 0}, "x y",
              "From the first, which is the origin of the map, heading for the second, to the last.")
        .angle("deadband_deg", s.deadband_rad, {0.1, 90}, "Heading error that calls for a short turn.")
        .angle("approach_deg", s.approach_rad_per_m, {0, 90},
               "Heading back to the leg for each metre beside it.")
        .angle("max_approach_deg", s.max_approach_rad, {0, 90}, "At most.");
}

ParameterTable cart_table(PushSettings& s) {
    return ParameterTable(
               "cart",
               "A cart that a person pushes through the waypoints, if [route] drive = pushed. Speed, "
               "acceleration and turn rate have no jumps.")
        .real("corner_radius_m", s.corner_radius_m, {0.1, 100},
              "Radius of a bend where it is tightest; less where legs are too short for that.")
        .real("speed_mps", s.speed_mps, {0.05, 40}, "Speed where nothing slows it down.")
        .real("sigma_speed", s.sigma_speed, {0, 0.3},
              "Standard deviation of the speed along the way, as a part of it.")
        .real("speed_up_s", s.speed_up_s, {0.2, 60}, "Time from standstill to full speed, and back.")
        .angle("turn_dps", s.turn_radps, {5, 360}, "Bends are taken so slowly that it turns no faster.")
        .real("standstill_s", s.standstill_s, {1, 3600}, "How long it stands at the start.")
        .real("end_standstill_s", s.end_standstill_s, {1, 3600}, "How long it stands at the end.")
        .real("stop_every_m", s.stop_every_m, {0, 1e6}, "Way from stop to stop, about; 0: no stops.")
        .real("stop_s", s.stop_s, {1.5, 3600}, "How long a stop takes.")
        .real("slip_turn", s.slip_turn, {0, 0.2},
              "Part of its way that the inner wheel loses in a bend, for each m/s^2 to its side; at most "
              "half. Also "
              "of a car on a recorded [path].")
        .real("sigma_side_m", s.sigma_side_m, {0, 0.2},
              "Standard deviation of how far it strays beside its path; it turns as it does.");
}

ParameterTable vehicle_table(VehicleSettings& v) {
    return ParameterTable(
               "vehicle",
               "Two driven wheels that know three ways to drive: straight, left, right. Slip is what "
               "wheels lose on the ground, and encoders do not see.")
        .real("track_width_m", v.track_width_m, {0.05, 10}, "Distance of the wheels.")
        .real("straight_mps", v.straight_mps, {0.001, 100}, "Speed of both wheels, driving straight.")
        .real("turn_outer_mps", v.turn_outer_mps, {0.001, 100}, "Speed of the outer wheel in a turn.")
        .real("turn_inner_mps", v.turn_inner_mps, {-100, 100}, "Speed of the inner wheel in a turn.")
        .real("wheel_lag_s", v.wheel_lag_s, {0, 10}, "Time constant with which a wheel follows its command.")
        .real("wander", v.wander, {0, 0.5},
              "Standard deviation of wheel speeds about their command, as a part of it.")
        .real("wander_s", v.wander_s, {0, 1000}, "Correlation time of that.")
        .real("slip_straight", v.slip_straight, {-1, 1}, "Part of the way that is lost driving straight.")
        .real("slip_turn_outer", v.slip_turn_outer, {-1, 1}, "Part that the outer wheel loses in a turn.")
        .real("slip_turn_inner", v.slip_turn_inner, {-5, 5}, "Part that the inner wheel loses in a turn.")
        .real("sigma_slip_turn", v.sigma_slip_turn, {0, 1},
              "Standard deviation of the inner wheel's part, from one turn to the next.")
        .real("sigma_straight_m", v.sigma_straight_m, {0, 1},
              "Random way of a wheel after 1 m, driving straight.")
        .real("sigma_turn_m", v.sigma_turn_m, {0, 1}, "Random way of a wheel after 1 m in turns.")
        .real("sigma_side_m", v.sigma_side_m, {0, 1}, "Random way to the side after 1 m.")
        .real("bumps_hz", v.bumps_hz, {0, 100}, "How often something on the ground turns the vehicle.")
        .angle("sigma_bump_deg", v.sigma_bump_rad, {0, 90}, "By how much.");
}

}  // namespace

ParameterTable Scenario::simulation_table() {
    return ParameterTable("simulation", "Makes a log and its truth from a scenario.")
        .seed("seed", seed, "For whatever is drawn at random: the same seed gives the same bytes.")
        .list("sensors", sensors, "Sensors of the vehicle, each with the section of its name.")
        .real("start_s", start_utc_s, {0, 4e9},
              "Time of the first observations, in seconds since 1970 (UTC).")
        .real("truth_hz", truth_hz, {0, 1000},
              "The true path has so many more poses a second, besides those at scans; 0: none.")
        .real("step_s", drive.step_s, {1e-4, 0.1}, "Step of the vehicle's motion.")
        .real("control_s", drive.control_s, {1e-3, 10}, "Time from one command to the next.")
        .real("longest_s", drive.longest_s, Range::positive(), "A drive that takes longer does not arrive.");
}

std::vector<ParameterTable> Scenario::tables() {
    return {simulation_table(),
            world_table(plan, generator, town_seed, sigma_tilt_rad),
            office_table(office),
            campus_table(campus),
            town_table(town),
            terrain_table(terrain),
            traffic_table(traffic),
            path_table(path),
            route_table(waypoints, laps, driving, driver),
            cart_table(push),
            vehicle_table(vehicle)};
}

}  // namespace loopline::simulation
