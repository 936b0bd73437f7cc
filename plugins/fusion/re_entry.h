/// When it is the path that is wrong: fixes that it refuses have agreed with one another for long.
#pragma once

#include <Eigen/Core>
#include <deque>
#include <functional>
#include <optional>

#include "api/stamp.h"

namespace loopline::fusion {

/// A signal that reflects off a house agrees with itself as well as a good one, for some seconds: the more
/// fixes a path rests on, the longer those that speak against it must last. Some of these may be wrong again.
class ReEntry {
 public:
    struct Fix {
        StampNs stamp_ns = 0;
        double way_m = 0;          ///< of the vehicle up to there
        double sigma_m = 0;        ///< standard deviation, east and north each
        double white_m = 0;        ///< of what of that neighbouring fixes do not share
        bool wheels_lead = false;  ///< alone: they slip, which looks like a jump of the fixes
    };
    /// From now on fixes are held against a path.
    void begin(StampNs stamp_ns, double way_m);
    /// One that agrees with it.
    void used(const Fix& fix, double after_s);
    enum class Verdict {
        path_holds,
        path_drifted,   ///< since fixes agreed with it
        contradiction,  ///< farther than it can have drifted: these or those before are wrong, not yet known
                        ///< which
        path_was_wrong  ///< they spoke for it less than others speak against it
    };
    /// One that does not, and how far it is off. The path holds unless none was used for `after_s`, or for
    /// twice the time for which fixes agreed with it (15 s at least), if that is less, and those of the last
    /// seconds are off by the same; or most of all that came for so long are; or they depart from the path
    /// little by little.
    Verdict refused(const Fix& fix, const Eigen::Vector3d& off_m, double after_s);
    /// For how long fixes have agreed with the path.
    double rests_on_s() const { return rests_on_s_; }
    /// By far longer than others have with another one.
    bool outweighs(double others_s) const;

 private:
    template <class Archive>
    friend void fields(Archive&, ReEntry&);
    struct Judged : Fix {
        bool used = false;
        Eigen::Vector3d off_m = Eigen::Vector3d::Zero();
    };
    void see(const Judged& fix, double for_s);
    /// For how long fixes have spoken against the path, what part of all that came, and whether the first of
    /// them was off by more than a path may drift.
    struct Against {
        double span_s = 0, part = 0;
        bool too_far = false;
    };
    Against against_the_path(double after_s) const;
    std::size_t most_others(const std::function<bool(const Judged&)>& is_on_line) const;

    std::deque<Judged> latest_;
    Fix begun_;              ///< the path, or its latest re-entry
    Fix last_used_;          ///< since then, or that
    double rests_on_s_ = 0;  ///< time for which fixes agreed with it
};

}  // namespace loopline::fusion
