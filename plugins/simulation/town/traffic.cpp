#include "simulation/town/traffic.h"

#include <algorithm>
#include <cmath>

#include "simulation/random_stream.h"
#include "simulation/town/car_shapes.h"

namespace loopline::simulation {
namespace {

constexpr StampNs look_ns = 100'000'000;    ///< from look to look at the vehicle's way
constexpr StampNs seen_ns = 9'000'000'000;  ///< before and after the meeting
constexpr double oncoming_lane_m = 3.3;
constexpr double speed_up_mps2 = 2;

/// From standstill, `since_s` after it began to move.
double way_since_m(double since_s, double speed_mps) {
    const double speeding_up_s = speed_mps / speed_up_mps2;
    if (since_s <= 0) return 0;
    if (since_s < speeding_up_s) return speed_up_mps2 / 2 * since_s * since_s;
    return speed_mps * (since_s - speeding_up_s / 2);
}

StampNs in_ns(double time_s) {
    return static_cast<StampNs>(std::llround(time_s * 1e9));
}

}  // namespace

Traffic::Traffic(const Street& driven, const Drive& drive, const Ground& ground, const Lots& lots,
                 const TrafficSettings& settings, std::uint64_t seed)
    : driven_(&driven), ground_(&ground), step_ns_(look_ns) {
    const StampNs end_ns = drive.motion.duration_ns();
    Eigen::Vector2d last_m = drive.motion.planar_pose_at(0).translation();
    double way_m = 0;
    for (StampNs time_ns = 0; time_ns <= end_ns; time_ns += step_ns_) {
        const Eigen::Vector2d here_m = drive.motion.planar_pose_at(time_ns).translation();
        way_m += (here_m - last_m).norm();
        last_m = here_m;
        ways_m_.push_back(way_m);
    }
    add_moving(settings, lots, end_ns, seed);
    add_standing(settings, lots, seed);
}

void Traffic::add_if_clear(Car car, const CarShape& shape, const Lots& lots) {
    if (!keeps_clear(car, shape, lots)) return;
    car.mesh = meshes_.size();
    cars_.push_back(car);
    TriangleMesh mesh;
    add_car(mesh, Pose3(), shape);
    meshes_.push_back(std::move(mesh));
}

void Traffic::add_moving(const TrafficSettings& settings, const Lots& lots, StampNs end_ns,
                         std::uint64_t seed) {
    RandomStream random(seed, "traffic");
    if (settings.oncoming_s > 0)
        for (double time_s = 3; in_ns(time_s) < end_ns;
             time_s += settings.oncoming_s * random.uniform(0.4, 1.6)) {
            const StampNs meet_ns = in_ns(time_s);
            const CarShape shape = draw_car(random);
            const double speed_mps = settings.oncoming_mps * random.uniform(0.7, 1.3);
            add_if_clear({0, meet_ns - seen_ns, meet_ns + seen_ns, Kind::oncoming, true,
                          vehicle_way_m(meet_ns), meet_ns, speed_mps},
                         shape, lots);
        }
    for (double time_s = 0; settings.ahead > 0 && in_ns(time_s) < end_ns;) {
        const double alone_s = 30 * (1 - settings.ahead) * random.uniform(0.3, 1.7),
                     ahead_s = 30 * settings.ahead * random.uniform(0.3, 1.7);
        const StampNs from_ns = in_ns(time_s + alone_s);
        const double gap_m = random.uniform(12, 25), drift_mps = random.uniform(-0.2, 0.3);
        add_if_clear({0, from_ns, from_ns + in_ns(ahead_s), Kind::ahead, false, gap_m, from_ns, drift_mps},
                     draw_car(random), lots);
        time_s += alone_s + ahead_s;
    }
}

/// They leave before the vehicle arrives; on its lane faster than it follows.
void Traffic::add_standing(const TrafficSettings& settings, const Lots& lots, std::uint64_t seed) {
    if (settings.standing_per_km <= 0 || ways_m_.empty()) return;
    RandomStream random(seed, "standing traffic");
    const double spacing_m = 1000 / settings.standing_per_km;
    const double last_m = ways_m_.back() - 50;  // whose place is seen after it left
    for (double way_m = 30; way_m < last_m; way_m += spacing_m * random.uniform(0.4, 1.6)) {
        const bool other_lane = random.uniform(0, 1) < 0.5;
        const double leaves_when_at_m = way_m + random.uniform(-45, -20);
        const StampNs leaves_ns = vehicle_is_at_ns(leaves_when_at_m);
        const double speed_mps = 1.5 * settings.oncoming_mps;
        add_if_clear({0, 0, leaves_ns + seen_ns, Kind::leaving, other_lane, way_m, leaves_ns, speed_mps},
                     draw_car(random), lots);
    }
}

double Traffic::vehicle_way_m(StampNs time_ns) const {
    const double step = std::clamp(static_cast<double>(time_ns) / static_cast<double>(step_ns_), 0.0,
                                   static_cast<double>(ways_m_.size() - 1));
    const auto i = std::min(static_cast<std::size_t>(step), ways_m_.size() - 1);
    const auto j = std::min(i + 1, ways_m_.size() - 1);
    return ways_m_[i] + (step - static_cast<double>(i)) * (ways_m_[j] - ways_m_[i]);
}

/// When it first gets there.
StampNs Traffic::vehicle_is_at_ns(double way_m) const {
    const auto found = std::lower_bound(ways_m_.begin(), ways_m_.end(), way_m);
    return (found - ways_m_.begin()) * step_ns_;
}

Pose2 Traffic::place(const Car& car, StampNs time_ns) const {
    const double since_s = seconds_between(car.meet_ns, time_ns);
    const double driven_m =
        car.kind == Kind::leaving ? way_since_m(since_s, car.speed_mps) : car.speed_mps * since_s;
    if (car.kind == Kind::ahead) return driven_->at(vehicle_way_m(time_ns) + car.way_m + driven_m);
    if (!car.other_lane) return driven_->at(car.way_m + driven_m);
    return driven_->at(car.way_m - driven_m) * Pose2{0, oncoming_lane_m, M_PI};
}

bool Traffic::keeps_clear(const Car& car, const CarShape& shape, const Lots& lots) const {
    for (StampNs time_ns = car.from_ns; time_ns <= car.to_ns; time_ns += 2 * look_ns) {
        const Pose2 T_map_car = place(car, time_ns);
        if (!lots.is_free({T_map_car, shape.length_m + 0.5, shape.width_m + 0.3})) return false;
        const Eigen::Vector2d vehicle_m = driven_->at(vehicle_way_m(time_ns)).translation();
        if ((vehicle_m - T_map_car.translation()).norm() < 2.5) return false;
    }
    return true;
}

std::vector<MovingBody> Traffic::at(StampNs time_ns) const {
    std::vector<MovingBody> bodies;
    for (const Car& car : cars_) {
        if (time_ns < car.from_ns || time_ns > car.to_ns) continue;
        const Pose2 T_map_car = place(car, time_ns);
        bodies.push_back({car.mesh, on_floor(T_map_car, ground_->below(T_map_car))});
    }
    return bodies;
}

}  // namespace loopline::simulation
