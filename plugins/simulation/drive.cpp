#include "simulation/drive.h"

#include <algorithm>
#include <cmath>

namespace loopline::simulation {

WheelPair Drive::rim_at(StampNs time_ns) const {
    const StampNs step_ns = motion.step_ns();
    if (time_ns <= 0 || rim_m.empty()) return {};
    if (time_ns >= motion.duration_ns()) return rim_m.back();
    const auto step = static_cast<std::size_t>(time_ns / step_ns);
    const double part = static_cast<double>(time_ns % step_ns) / static_cast<double>(step_ns);
    const WheelPair before = step == 0 ? WheelPair{} : rim_m[step - 1], &after = rim_m[step];
    return {before.left + part * (after.left - before.left),
            before.right + part * (after.right - before.right)};
}

std::optional<Drive> drive_route(const Waypoints& waypoints, const DriveSettings& settings,
                                 const DriverSettings& driver_settings,
                                 const VehicleSettings& vehicle_settings, std::uint64_t seed) {
    const auto step_ns = static_cast<StampNs>(std::llround(settings.step_s * 1e9));
    const double step_s = static_cast<double>(step_ns) * 1e-9;
    const auto steps_per_command =
        static_cast<std::size_t>(std::max<long long>(1, std::llround(settings.control_s / step_s)));
    const auto most_steps = static_cast<std::size_t>(settings.longest_s / step_s);

    Driver driver(waypoints, driver_settings, vehicle_settings);
    Vehicle vehicle(vehicle_settings, step_s, RandomStream(seed, "vehicle"));
    Drive drive;
    drive.motion = TrueMotion(driver.start(), step_ns);
    WheelPair rim_m;
    Regime regime = Regime::straight;
    for (std::size_t step = 0; step < most_steps; ++step) {
        if (step % steps_per_command == 0) {
            regime = driver.command(drive.motion.last());
            if (driver.arrived()) return drive;
            if (drive.commands.empty() || drive.commands.back().regime != regime)
                drive.commands.push_back({drive.motion.duration_ns(), regime});
        }
        const VehicleStep moved = vehicle.step(regime);
        drive.motion.append(moved.motion);
        rim_m.left += moved.rim_m.left;
        rim_m.right += moved.rim_m.right;
        drive.rim_m.push_back(rim_m);
    }
    return std::nullopt;
}

}  // namespace loopline::simulation
