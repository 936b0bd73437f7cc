/// Where was the vehicle, by dead reckoning, when a scan was taken? Brings odometry samples and scans of one
/// log together, each in the log's order.
///
/// A scan waits until odometry of its time or later has come, then its pose lies on the arc between two
/// samples that enclose its stamp. In some logs stamps go backwards while the order in the file is right:
/// therefore the pair of samples that is nearest to the scan *in the file* wins, and a scan that no pair
/// encloses takes the pose of its neighbour in the file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>

#include "api/pose2.h"
#include "api/stamp.h"
#include "api/twist2.h"
#include "odometry/differential_drive.h"

namespace loopline {

struct OdometrySample {
    StampNs stamp_ns = 0;
    Pose2 T_odom_base;
    std::optional<WheelTicks> ticks;
};

struct OdometryAtScansSettings {
    double max_delay_s =
        2;  ///< how far, in odometry time, a scan may stand from the samples of its time in the log
    double max_extrapolation_s = 0.5;  ///< motion is continued beyond the last sample for no longer than this
};

/// A scan with its pose. `scan` is what the caller gave to add_scan().
struct PlacedScan {
    enum class By { interpolation, file_order, extrapolation };
    std::uint64_t scan = 0;
    Pose2 T_odom_base;
    std::optional<Twist2>
        velocity;  ///< m/s and rad/s in the base frame; none without two samples at different times
    std::optional<WheelTicks> ticks;  ///< counts at the scan, rounded; none unless both samples have them
    By by = By::interpolation;
};

class OdometryAtScans {
 public:
    explicit OdometryAtScans(const OdometryAtScansSettings& settings = {}) : settings_(settings) {}

    void add_odometry(const OdometrySample& sample);
    void add_scan(std::uint64_t scan, StampNs stamp_ns);

    /// The next scan, in the order in which they came, as soon as its pose is known.
    std::optional<PlacedScan> next() {
        if (scans_.empty()) return std::nullopt;
        auto placed = place(scans_.front());
        if (placed) scans_.pop_front();
        return placed;
    }
    /// The next scan when the log has ended: what still waits is extrapolated at constant velocity. None
    /// without odometry.
    std::optional<PlacedScan> next_at_end();

    std::size_t waiting() const { return scans_.size(); }

 private:
    template <class Archive>
    friend void fields(Archive&, OdometryAtScans&);
    struct WaitingScan {
        std::uint64_t scan;
        StampNs stamp_ns;
        std::ptrdiff_t before;  ///< index, counted from the log's first, of the last sample before it in the
                                ///< log; -1: none
    };

    /// The motion from a sample to the next one, on which several scans lie as a rule.
    struct Segment {
        std::ptrdiff_t first = -1;  ///< of the two samples; -1: none yet
        PreparedPose2 T_odom_base;
        Twist2 motion;
        std::optional<Twist2> velocity;  ///< none if the two are at about the same time
    };

    std::optional<PlacedScan> place(const WaitingScan& scan);
    PlacedScan on_segment(const WaitingScan& scan, std::ptrdiff_t first, double u);
    PlacedScan at_sample(const WaitingScan& scan, std::ptrdiff_t index);
    PlacedScan at_file_neighbour(const WaitingScan& scan);
    const Segment& segment_from(std::ptrdiff_t first);
    bool may_still_be_enclosed(const WaitingScan& scan) const;
    void forget_old_samples();

    std::ptrdiff_t begin() const { return forgotten_; }
    std::ptrdiff_t end() const { return forgotten_ + static_cast<std::ptrdiff_t>(samples_.size()); }
    const OdometrySample& sample(std::ptrdiff_t index) const {
        return samples_[static_cast<std::size_t>(index - forgotten_)];
    }

    OdometryAtScansSettings settings_;
    std::deque<OdometrySample> samples_;
    std::ptrdiff_t forgotten_ = 0;
    std::deque<WaitingScan> scans_;
    Segment segment_;  ///< the latest one in use
};

}  // namespace loopline
