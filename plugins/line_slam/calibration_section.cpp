#include "line_slam/calibration_section.h"

#include <cmath>
#include <cstdio>

#include "api/parameters.h"

namespace loopline::line_slam {
namespace {

using Control = IntervalParameters::Control;

std::string rounded(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.2g", value);
    return text;
}

std::string fixed(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.1f", value);
    return text;
}

std::string counted(int count, const char* what) {
    return std::to_string(count) + " " + what + (count == 1 ? "" : "s");
}

const char* wheel_key(Wheel wheel) {
    return wheel == Wheel::left ? "left" : "right";
}

double presumed_slip(const RegimeParameters& regime, Wheel wheel) {
    return wheel == Wheel::left ? regime.slip_left : regime.slip_right;
}

class Section {
 public:
    Section(const DriveCalibration& calibration, const CalibratedRun& run)
        : calibration_(calibration), run_(run) {
        section_.section = "line_slam";
    }

    Calibration take() {
        add_track_width();
        section_.remarks.push_back("Walls were seen " + rounded(calibration_.delay_s.value) +
                                   " s later than the scans' stamps say (standard error " +
                                   rounded(calibration_.delay_s.standard_error) +
                                   " s), which these keys have been freed of.");
        for (const Regime regime : all_regimes) add_regime(regime);
        add("sigma_side_m", calibration_.sigma_side_m, "all motions together");
        add("sigma_rest_m", calibration_.sigma_rest_m,
            "all motions together; without it the other noises would be too much");
        return std::move(section_);
    }

 private:
    void add(const std::string& key, const Estimate& estimate, const std::string& comment) {
        section_.keys.push_back({key, estimate.value, estimate.standard_error, comment});
    }
    void leave_out(const std::string& key, const std::string& reason) {
        section_.keys.push_back({key, std::nullopt, 0, reason});
    }

    void add_track_width() {
        const Estimate& track_m = calibration_.track_width_m;
        if (!calibration_.track_told) {
            leave_out("track_width_m",
                      "by itself this log would tell it with a standard error of " +
                          rounded(track_m.standard_error) +
                          " m, since slip of the wheels does the same; the slips below hold for " +
                          number_text(track_m.value));
            return;
        }
        add("track_width_m", track_m, "turns of different curvature in all regimes");
        if (run_.control == Control::measured)
            section_.keys.push_back({"odometry_track_width_m", run_.drive.odometry_width_m(), 0,
                                     "what the run that this rests on took the log's odometry for"});
    }

    void add_regime(Regime regime) {
        const RegimeAmount& amount = calibration_.amounts[static_cast<std::size_t>(regime)];
        const std::string name = regime_key(regime);
        if (amount.steps == 0) {
            constexpr const char* missing[] = {"no drive straight on", "no turn to the left",
                                               "no turn to the right"};
            leave_out(name + "_*", std::string(missing[static_cast<int>(regime)]) + " in this log");
            return;
        }
        const bool commanded = run_.control == Control::commanded;
        for (const Wheel wheel : both_wheels) {
            if (commanded)
                add_effective_speed(regime, wheel);
            else if (run_.regimes_from_log)
                add(name + "_" + wheel_key(wheel) + "_mps", amount.speed_mps[static_cast<std::size_t>(wheel)],
                    basis(amount, wheel) + "; of the rim, for control = commanded");
        }
        for (const Wheel wheel : both_wheels) add_slip(regime, wheel);
        for (const Wheel wheel : both_wheels) add_noise(regime, wheel);
    }

    /// "12.3 m in 4.0 s, 5 steps in 1 stretch"
    static std::string basis(const RegimeAmount& amount, Wheel wheel) {
        return fixed(of(amount.rolled_m, wheel)) + " m in " + fixed(amount.duration_s) + " s, " +
               counted(amount.steps, "step") + " in " +
               (amount.stretches == 1 ? "1 stretch" : std::to_string(amount.stretches) + " stretches");
    }

    /// Where the control is a speed, slip is what is wrong with it.
    void add_effective_speed(Regime regime, Wheel wheel) {
        const RegimeParameters& known = run_.regimes[static_cast<std::size_t>(regime)];
        const double speed_mps = wheel == Wheel::left ? known.commanded.left_mps : known.commanded.right_mps;
        const Estimate& slip = calibration_.wheel(regime, wheel).slip;
        if (!is_told(regime, wheel)) return;
        add(std::string(regime_key(regime)) + "_" + wheel_key(wheel) + "_mps",
            {(1 - slip.value) * speed_mps, slip.standard_error * std::abs(speed_mps)},
            basis(calibration_.amounts[static_cast<std::size_t>(regime)], wheel) + "; over ground");
    }

    /// Better than the run was told, or against it.
    bool is_told(Regime regime, Wheel wheel) const {
        const Estimate& slip = calibration_.wheel(regime, wheel).slip;
        const double change =
            slip.value - presumed_slip(run_.regimes[static_cast<std::size_t>(regime)], wheel);
        return slip.standard_error < run_.drive.sigma_scale || std::abs(change) > 2 * slip.standard_error;
    }

    void add_slip(Regime regime, Wheel wheel) {
        const WheelEstimate& estimate = calibration_.wheel(regime, wheel);
        const std::string key = std::string(regime_key(regime)) + "_slip_" + wheel_key(wheel),
                          on = basis(calibration_.amounts[static_cast<std::size_t>(regime)], wheel);
        if (!is_told(regime, wheel))
            leave_out(key, "estimated as " + rounded(estimate.slip.value) + " with a standard error of " +
                               rounded(estimate.slip.standard_error) + " from " + on +
                               ", no better than what the run was told");
        else if (run_.control == Control::commanded)
            section_.keys.push_back({key, 0.0, 0, "the speed above is the one over ground"});
        else
            add(key, estimate.slip, on);
    }

    void add_noise(Regime regime, Wheel wheel) {
        const WheelEstimate& estimate = calibration_.wheel(regime, wheel);
        const std::string key = std::string(regime_key(regime)) + "_sigma_" + wheel_key(wheel) + "_m",
                          on = basis(calibration_.amounts[static_cast<std::size_t>(regime)], wheel);
        const double relative_error = estimate.sigma_m.standard_error / estimate.sigma_m.value;
        if (relative_error > largest_relative_error) {
            leave_out(key, "some " + rounded(estimate.sigma_m.value) + ", by a factor of " +
                               rounded(std::exp(relative_error)) + " either way, from " + on);
            return;
        }
        std::string comment = on;
        if (estimate.scatter_is_told())
            comment += "; of it " + rounded(estimate.random_way_m.value) +
                       " are random way, the rest a slip that " + "scatters by " +
                       rounded(estimate.scatter.value) + " from stretch to stretch";
        add(key, estimate.sigma_m, comment);
    }

    const DriveCalibration& calibration_;
    const CalibratedRun& run_;
    Calibration section_;
};

}  // namespace

Calibration calibration_section(const DriveCalibration& calibration, const CalibratedRun& run) {
    return Section(calibration, run).take();
}

}  // namespace loopline::line_slam
