/// Wide-interval prediction with re-prediction: Hu, Chen, Zhang 2012, sections 3.1.1 and 3.1.2. Scans come
/// faster than the vehicle moves, so only every N-th becomes a step of the filter. The motion until then is
/// predicted from the wheel speeds; where these change within the interval, the prediction is discarded and
/// made again in pieces.
#pragma once

#include <cmath>
#include <optional>
#include <vector>

#include "line_slam/motion_model.h"
#include "line_slam/regimes.h"

namespace loopline::line_slam {

/// What is known of a scan before anybody looks at it.
struct ScanMotion {
    Pose2 T_odom_base;                ///< by the wheels
    double duration_s = 0;            ///< since the scan before
    std::optional<Regime> commanded;  ///< where the log tells it
    double commanded_at = 0;          ///< the part of the duration after which it was; 0: before
};

struct IntervalParameters {
    enum class Kind { fixed, adaptive };
    enum class Control { measured, commanded };

    Kind kind = Kind::fixed;
    int scans = 1;  ///< N, of a step; with `adaptive`: at most
    // Adaptive: a step is due when the vehicle moved, turned, or may have slipped by this much.
    double max_way_m = 0.15;
    double max_turn_rad = 4 * M_PI / 180;
    double max_sigma_m = 0.02;  ///< of the difference of both wheels' travel
    Control control = Control::measured;
    bool re_prediction = true;
    Regimes regimes;
};

/// Motion under one regime, by the control alone: nothing is known of slip yet.
struct DrivePiece {
    Regime regime = Regime::straight;
    WheelTravel rolled;
    double duration_s = 0;
};

/// Collects scans until a step is due.
class WideInterval {
 public:
    WideInterval(const IntervalParameters& parameters, const DriveParameters& drive)
        : parameters_(parameters), drive_(drive) {}

    /// One more scan. True if it is one for a step of the filter; the first is.
    bool add(const ScanMotion& motion);

    /// Control and noise for eq. (3)-(6) from the last step to the latest scan: one piece, or as many as
    /// there were regimes, eq. (7)-(10).
    std::vector<MotionPiece> pieces() const;

    /// The same as a pose: the vehicle at the latest scan, in its frame at the last step.
    Pose2 T_step_base_predicted(const WheelCalibration& calibration) const;

    Regime regime() const { return regime_; }
    /// Covariance of (x, y, phi) that the wheels' noise adds on the way `predicted`, without that of a
    /// vehicle at rest.
    Eigen::Matrix3d noise_on(const Pose2& predicted, Regime regime) const;

    /// What the control was from the last step to the latest scan, split at every change of the regime.
    std::vector<DrivePiece> drive_pieces() const;

    /// By the wheels alone.
    const Pose2& T_step_base() const { return T_step_base_; }
    bool empty() const { return scans_ == 0; }

    /// The step was made: the next interval begins at the latest scan.
    void restart();

    /// Predictions that were discarded and made again.
    int re_predictions() const { return re_predictions_; }

 private:
    template <class Archive>
    friend void fields(Archive&, WideInterval&);
    /// Between two changes of the regime.
    struct Stretch {
        Regime regime;
        Pose2 T_step_from;  ///< where it begins, by the wheels
        double from_s;      ///< and when, since the step
    };
    void begin_stretch(Regime before, const ScanMotion& motion);
    bool is_due() const;
    /// Calls `take` with each piece of the control that the prediction is made from, and with each that there
    /// was.
    template <class Take>
    void each_predicted(const Take& take) const;
    template <class Take>
    void each_driven(const Take& take) const;
    WheelTravel without_slip(Regime regime, WheelTravel rolled) const;
    MotionPiece piece(Regime regime, const WheelTravel& rolled) const;
    const WheelSpeed& commanded(Regime regime) const;
    WheelTravel measured_travel(const Pose2& T_old_new) const;

    IntervalParameters parameters_;
    DriveParameters drive_;
    RegimeWatch watch_;

    Regime regime_ = Regime::straight, regime_at_step_ = Regime::straight;
    WheelSpeed speed_at_step_;
    bool begun_ = false;
    PreparedPose2 T_step_odom_;
    Pose2 T_odom_base_, T_step_base_, T_step_previous_;
    std::vector<Stretch> stretches_;
    double duration_s_ = 0, last_duration_s_ = 0;
    double way_m_ = 0;
    int scans_ = 0;
    int re_predictions_ = 0;
};

}  // namespace loopline::line_slam
