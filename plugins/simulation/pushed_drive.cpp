#include "simulation/pushed_drive.h"

#include <algorithm>
#include <cmath>

#include "simulation/random_waves.h"

namespace loopline::simulation {
namespace {

/// Where hands let the cart stray to.
class Hands {
 public:
    Hands(const PushSettings& push, RandomStream random)
        : side_m_(push.sigma_side_m, shortest(push), 4 * shortest(push), random) {}

    Pose2 T_world_base(const CartPath& path, double way_m) const {
        const PathPoint point = path.at(way_m);
        const double u = std::min(way_m / fade_in_m, 1.0);
        // From 0 to 1 with three derivatives that vanish at both ends: the turn rate takes two of them.
        const double fade = u * u * u * u * (35 + u * (u * (70 - 20 * u) - 84));
        const double fade_slope = 140 * std::pow(u * (1 - u), 3) / fade_in_m;
        const double aside_m = fade * side_m_.at(way_m);
        const double slope = fade * side_m_.slope_at(way_m) + fade_slope * side_m_.at(way_m);
        // The tangent of the path that is `aside_m` to the left of a curved one.
        const double turned_rad = std::atan2(slope, 1 - point.curvature_per_m * aside_m);
        return point.T_world_path * Pose2{0, aside_m, turned_rad};
    }

 private:
    /// Wavelength: nobody steers in less than 3 s to the other side and back.
    static double shortest(const PushSettings& push) { return 3 * std::max(1.0, push.speed_mps); }
    static constexpr double fade_in_m = 2;  ///< a drive begins on its path

    RandomWaves side_m_;
};

/// Ways of the rims that belong to a motion over ground.
class Wheels {
 public:
    Wheels(const VehicleSettings& vehicle, double slip_turn, double step_s, RandomStream random)
        : vehicle_(vehicle), slip_turn_(slip_turn), step_s_(step_s), random_(random) {}

    WheelPair roll(const Twist2& motion) {
        const double half_turn_m = motion.turn_rad * vehicle_.track_width_m / 2;
        // To the left: the left wheel is the inner one.
        const double sideways_mps2 = motion.turn_rad * motion.forward_m / (step_s_ * step_s_);
        const double slip = std::min(slip_turn_ * std::abs(sideways_mps2), most_slip);
        return {rim_m(motion.forward_m - half_turn_m, sideways_mps2 > 0 ? slip : 0),
                rim_m(motion.forward_m + half_turn_m, sideways_mps2 < 0 ? slip : 0)};
    }

 private:
    static constexpr double most_slip = 0.5;

    double rim_m(double ground_m, double slip_in_turn) {
        return (ground_m + random_.normal(vehicle_.sigma_straight_m * std::sqrt(std::abs(ground_m)))) /
               (1 - vehicle_.slip_straight) / (1 - slip_in_turn);
    }

    VehicleSettings vehicle_;
    double slip_turn_, step_s_;
    RandomStream random_;
};

/// Way over ground by way on the plan in each step.
double uphill(const TrueMotion& motion, std::size_t step) {
    const StampNs from_ns = static_cast<StampNs>(step) * motion.step_ns();
    const Eigen::Vector3d way_m =
        motion.pose_at(from_ns + motion.step_ns()).translation_m - motion.pose_at(from_ns).translation_m;
    const double plan_m = way_m.head<2>().norm();
    return plan_m > 1e-9 ? way_m.norm() / plan_m : 1;
}

template <class Stretch>
void roll(Drive& drive, const VehicleSettings& vehicle, double slip_turn, std::uint64_t seed,
          const Stretch& stretch) {
    Wheels wheels(vehicle, slip_turn, seconds_between(0, drive.motion.step_ns()),
                  RandomStream(seed, "cart wheels"));
    drive.rim_m.clear();
    WheelPair rim_m;
    std::size_t step = 0;
    for (Twist2 motion : drive.motion.twists()) {
        motion.forward_m *= stretch(step++);
        const WheelPair rolled_m = wheels.roll(motion);
        rim_m.left += rolled_m.left;
        rim_m.right += rolled_m.right;
        drive.rim_m.push_back(rim_m);
    }
}

}  // namespace

std::optional<Drive> push_along(const Waypoints& waypoints, const PushSettings& push,
                                const DriveSettings& settings, const VehicleSettings& vehicle,
                                std::uint64_t seed) {
    const auto step_ns = static_cast<StampNs>(std::llround(settings.step_s * 1e9));
    const CartPath path(waypoints, push.corner_radius_m);
    const auto ways_m = pushed_ways_m(path, push, seconds_between(0, step_ns), RandomStream(seed, "speed"));
    if (static_cast<double>(ways_m.size()) * settings.step_s > settings.longest_s) return std::nullopt;

    const Hands hands(push, RandomStream(seed, "hands"));
    Drive drive;
    double way_m = 0;
    Pose2 T_world_base = hands.T_world_base(path, 0);
    drive.motion = TrueMotion(T_world_base, step_ns);
    for (const double step_m : ways_m) {
        way_m += step_m;
        const Pose2 T_world_next = hands.T_world_base(path, way_m);
        drive.motion.append(log_se2(T_world_base.inverse() * T_world_next));
        T_world_base = T_world_next;
    }
    roll_wheels(drive, vehicle, push.slip_turn, seed);
    return drive;
}

void roll_wheels(Drive& drive, const VehicleSettings& vehicle, double slip_turn, std::uint64_t seed) {
    roll(drive, vehicle, slip_turn, seed, [](std::size_t) { return 1.0; });
}

void roll_wheels_uphill(Drive& drive, const VehicleSettings& vehicle, double slip_turn, std::uint64_t seed) {
    roll(drive, vehicle, slip_turn, seed, [&](std::size_t step) { return uphill(drive.motion, step); });
}

}  // namespace loopline::simulation
