/// How the path goes back to where it was certain, if what it has rested on since turns out to be wrong.
#include "fusion/earth_path.h"

namespace loopline::fusion {
namespace {

/// A heading that was found by reflected signals may be off by as much again.
constexpr double heading_in_doubt_rad = 0.1;
/// A fix may have been right all the same if the path was off by so many of its standard deviations.
constexpr double still_right = 4;

}  // namespace

void EarthPath::gain_foothold() {
    foothold_ = Foothold{*committed_, state_, fix_process_,    process_, used_ns_,
                         used_,       gaps_,  sum_of_squares_, squares_};
}

/// What became of a fix is told when it can't change any more.
void EarthPath::judge(const WaitingFix& waiting, FixUse use) {
    if (!foothold_) return tally(waiting.fix, use);
    ++count_[static_cast<std::size_t>(use)];
    since_.push_back({waiting, use});
}

void EarthPath::leave_foothold() {
    foothold_.reset();
    recent_steps_.for_each(0, recent_steps_.size(),
                           [&](const SmootherStep& step) { steps_.push_back(step); });
    recent_steps_ = {};
    for (const JudgedFix& judged : since_)
        if (tell_) tell_(judged.waiting.fix, judged.use);
    since_ = {};
}

/// All fixes since then once more, without those that it was off with, by `off_m`.
void EarthPath::go_back(double off_m) {
    const Foothold& then = *foothold_;
    committed_ = then.committed;
    recent_steps_ = {};
    state_ = then.state;
    state_.covariance(5, 5) += heading_in_doubt_rad * heading_in_doubt_rad;
    fix_process_ = then.fix_process;
    process_ = then.process;
    used_ns_ = then.used_ns;
    used_ = then.used;
    gaps_ = then.gaps;
    sum_of_squares_ = then.sum_of_squares;
    squares_ = then.squares;

    std::vector<JudgedFix> again;
    std::swap(again, since_);
    re_entry_.begin(pose(*committed_).stamp_ns, pose(*committed_).way_m);
    for (JudgedFix& judged : again) {
        const gnss::GnssFix& fix = judged.waiting.fix;
        const gnss::SigmaOfFix sigma = gnss::sigma_of(fix, settings_.noise);
        --count_[static_cast<std::size_t>(judged.use)];
        const double sigma_m = std::hypot(sigma.white_m.x(), sigma.correlated_m.x());
        judged.barred = judged.barred || (judged.use == FixUse::used && off_m > still_right * sigma_m);
        if (judged.barred)
            judged.use = FixUse::off_the_path;
        else if (judged.use == FixUse::used || judged.use == FixUse::off_the_path)
            judged.use = apply(fix);
        else if (judged.use == FixUse::withheld)
            look_at_withheld(fix);
        judge(judged.waiting, judged.use);
        since_.back().barred = judged.barred;
    }
}

}  // namespace loopline::fusion
