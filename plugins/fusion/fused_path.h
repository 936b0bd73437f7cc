/// What every filter of module "fusion" is: a path on the Earth by motions and fixes, in the order in which
/// they come.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "api/twist2.h"
#include "fusion/motion.h"
#include "gnss/gnss_fix.h"
#include "gnss/local_frame.h"

namespace loopline::fusion {

/// What became of a fix.
enum class FixUse {
    used,
    no_position,   ///< the receiver had none, or it is dead reckoning
    before_path,   ///< from before the odometry's first pose
    after_path,    ///< from after its last one
    late,          ///< what came after it is settled
    off_the_path,  ///< farther off than all uncertainty explains
    out_of_sync,   ///< no pose and no wheels within the threshold of time, where a filter wants that
    heading_never_found,
    withheld  ///< on purpose, to see how the path does without it
};
/// As part of a key: "off_the_path".
const char* name_of(FixUse use);
constexpr std::size_t fix_uses = static_cast<std::size_t>(FixUse::withheld) + 1;

/// What became of the motions that wheels told beside an odometry.
struct WheelUse {
    std::uint64_t used = 0;
    std::uint64_t slipped = 0;  ///< farther from the odometry's motion than all uncertainty explains
    double sum_of_squares = 0;  ///< normalised, of those that were used
    /// Over their number of directions: 1 if the noise is as thought.
    double mean_square() const { return used > 0 ? sum_of_squares / (3 * static_cast<double>(used)) : 0; }
};

/// When the heading was known: way of the odometry since the first pose, and its standard deviation.
struct HeadingFound {
    double way_m = 0, sigma_rad = 0;
};

struct PoseOnEarth {
    Pose3 T_enu_base;
    Matrix6d covariance = Matrix6d::Zero();  ///< of (shift, turn) along ENU, about the vehicle
};

class FusedPath {
 public:
    virtual ~FusedPath() = default;
    /// The odometry's next pose, later than the one before. `covariance`: what the motion since then adds, of
    /// (shift, turn) along the vehicle's axes there. `wheels`: what they tell of the same motion.
    virtual void take_pose(StampNs stamp_ns, const Pose3& T_odom_base, const Matrix6d& covariance,
                           const std::optional<Twist2>& wheels) = 0;
    /// `withheld`: it is not used but compared with.
    virtual void take_fix(const gnss::GnssFix& fix, bool withheld) = 0;

    virtual std::size_t poses() const = 0;
    /// At the latest pose; none before the heading is known.
    virtual std::optional<PoseOnEarth> known() const = 0;
    /// End of the log: all poses, as the filter leaves them. If the heading was never found, they are the
    /// odometry's.
    virtual std::vector<PoseOnEarth> finished() = 0;

    /// Told of every fix when it is known what became of it.
    using Tell = std::function<void(const gnss::GnssFix&, FixUse)>;
    void tell_fates_to(Tell tell) { tell_ = std::move(tell); }

    /// Local frame of the path on the Earth; none before the first fix.
    const std::optional<gnss::LocalFrame>& earth() const { return earth_; }
    const HeadingFound& heading() const { return heading_; }
    std::size_t count(FixUse use) const { return count_[static_cast<std::size_t>(use)]; }
    const WheelUse& wheel_use() const { return wheel_use_; }

 protected:
    void tally(const gnss::GnssFix& fix, FixUse use) {
        ++count_[static_cast<std::size_t>(use)];
        if (tell_) tell_(fix, use);
    }
    Tell tell_;
    std::optional<gnss::LocalFrame> earth_;
    HeadingFound heading_;
    std::array<std::size_t, fix_uses> count_{};
    WheelUse wheel_use_;
};

}  // namespace loopline::fusion
