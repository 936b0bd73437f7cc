/// How the path goes back to where it was certain, if what it has rested on since turns out to be wrong.
#include <cmath>

#include "fusion/earth_path.h"

namespace loopline::fusion {
namespace {

/// A heading that was found by reflected signals may be off by as much again.
constexpr double heading_in_doubt_rad = 0.1;
/// A fix may have been right all the same if the path was off by so many of its standard deviations.
constexpr double still_right = 4;
constexpr std::size_t most_footholds = 4;
/// Fixes that the path can't explain, but another one can.
constexpr std::size_t enough_others = 5;
constexpr double enough_others_s = 3;

/// Whether a path that is known so well does not explain a fix `off_m` away by chance.
bool is_close(const Innovation<3>& place, double off_m) {
    constexpr double by_far = 10;
    return by_far * std::sqrt(place.covariance.topLeftCorner<2, 2>().trace()) < off_m;
}

}  // namespace

void EarthPath::gain_foothold(const ReEntry& re_entry) {
    if (footholds_.size() == most_footholds) {
        footholds_.back().contradicted_m = 0;
        return;
    }
    Foothold now;
    now.committed = *committed_;
    now.steps = recent_steps_.size();
    now.fixes = since_.size();
    now.state = now.without = state_;
    now.re_entry = re_entry;
    now.rested_s = re_entry.rests_on_s();
    now.fix_process = fix_process_;
    now.process = process_;
    now.used_ns = used_ns_;
    now.used = used_;
    now.gaps = gaps_;
    now.sum_of_squares = sum_of_squares_;
    now.squares = squares_;
    footholds_.push_back(std::move(now));
}

/// That of the fixes before and after the latest foothold: `off_m`, though the motion from the one before it
/// leads to those after.
void EarthPath::remember_contradiction(const PresentFix& seen, double off_m) {
    if (footholds_.size() < 2 || footholds_.back().fixes != since_.size()) return;
    const Innovation<3> from_before = innovation_without(*(footholds_.end() - 2), seen);
    if (!passes(from_before)) return;
    footholds_.back().contradicted_m = off_m;
    footholds_.back().heading_holds = is_close(from_before, off_m);
}

/// Where the vehicle would be without what came since the foothold, against a fix; its slow error is another
/// one by now.
Innovation<3> EarthPath::innovation_without(const Foothold& foothold, const PresentFix& seen) const {
    return innovation_of(seen, with_new_fix_error(foothold.without, seen.sigma.correlated_m).after);
}

/// A fix that the path can't explain, `off_m` away: if the path as it would be without what came since a
/// foothold explains it and others before, more closely than by chance, they tell which was reflected.
bool EarthPath::others_agree_without(const PresentFix& seen, double off_m) {
    bool enough = false;
    for (Foothold& foothold : footholds_) {
        const Innovation<3> place = innovation_without(foothold, seen);
        if (!passes(place) || !is_close(place, off_m)) continue;
        if (foothold.agreeing++ == 0) foothold.agrees_ns = seen.fix.stamp_ns;
        enough = enough || (foothold.agreeing >= enough_others &&
                            seconds_between(foothold.agrees_ns, seen.fix.stamp_ns) >= enough_others_s);
    }
    return enough;
}

/// What became of a fix is told when it can't change any more.
void EarthPath::judge(const WaitingFix& waiting, FixUse use) {
    if (footholds_.empty()) return tally(waiting.fix, use);
    ++count_[static_cast<std::size_t>(use)];
    since_.push_back({waiting, use});
}

void EarthPath::leave_footholds() {
    footholds_.clear();
    recent_steps_.for_each(0, recent_steps_.size(),
                           [&](const SmootherStep& step) { steps_.push_back(step); });
    recent_steps_ = {};
    for (const JudgedFix& judged : since_)
        if (tell_) tell_(judged.waiting.fix, judged.use);
    since_ = {};
}

/// To the latest foothold from which the motion leads to the fix, and all fixes since then once more, without
/// those that were used, which the path was off with, by `off_m`.
void EarthPath::go_back(const PresentFix& seen, double off_m) {
    while (footholds_.size() > 1 && !passes(innovation_without(footholds_.back(), seen)))
        footholds_.pop_back();
    mark_used(footholds_.back().fixes, since_.size(), off_m, &JudgedFix::barred);
    for (JudgedFix& judged : since_) judged.outweighed = false;
    footholds_.back().contradicted_m = 0;
    use_again(is_close(innovation_without(footholds_.back(), seen), off_m));
}

/// A re-entry that no drift explains: fixes before it or after were reflected, and by then it was too early
/// to say which. What has spoken for longer since was right; but nothing reflects for as long as [fusion]
/// re_entry_s.
void EarthPath::weigh_latest_re_entry() {
    if (footholds_.size() < 2) return;
    const Foothold latest = footholds_.back();
    if (latest.contradicted_m == 0 || latest.rested_s > settings_.re_entry_s ||
        !re_entry_.outweighs(latest.rested_s))
        return;
    footholds_.pop_back();
    ++re_entries_;
    mark_used(footholds_.back().fixes, latest.fixes, latest.contradicted_m, &JudgedFix::outweighed);
    goes_back_ = true;
    use_again(latest.heading_holds);
    goes_back_ = false;
    look_ahead();
}

/// Of the fixes in that range, those which the path was off with, by `off_m`.
void EarthPath::mark_used(std::size_t from, std::size_t to, double off_m, bool JudgedFix::*as) {
    for (std::size_t k = from; k < to; ++k) {
        const gnss::SigmaOfFix sigma = gnss::sigma_of(since_[k].waiting.fix, settings_.noise);
        const double sigma_m = std::hypot(sigma.white_m.x(), sigma.correlated_m.x());
        if (since_[k].use == FixUse::used && off_m > still_right * sigma_m) since_[k].*as = true;
    }
}

/// All fixes since the latest foothold, from there on.
void EarthPath::use_again(bool heading_holds) {
    Foothold& then = footholds_.back();
    committed_ = then.committed;
    SetAside<SmootherStep> steps;
    recent_steps_.for_each(0, then.steps, [&](const SmootherStep& step) { steps.push_back(step); });
    recent_steps_ = std::move(steps);
    state_ = then.state;
    if (!heading_holds) state_.covariance(5, 5) += heading_in_doubt_rad * heading_in_doubt_rad;
    then.without = state_;
    then.agreeing = 0;
    re_entry_ = then.re_entry;
    fix_process_ = then.fix_process;
    process_ = then.process;
    used_ns_ = then.used_ns;
    used_ = then.used;
    gaps_ = then.gaps;
    sum_of_squares_ = then.sum_of_squares;
    squares_ = then.squares;

    const auto first = since_.begin() + static_cast<std::ptrdiff_t>(then.fixes);
    std::vector<JudgedFix> again(first, since_.end());
    since_.erase(first, since_.end());
    for (JudgedFix& judged : again) {
        const gnss::GnssFix& fix = judged.waiting.fix;
        --count_[static_cast<std::size_t>(judged.use)];
        if (judged.barred || judged.outweighed)
            judged.use = FixUse::off_the_path;
        else if (judged.use == FixUse::used || judged.use == FixUse::off_the_path)
            judged.use = apply(fix);
        else if (judged.use == FixUse::withheld)
            look_at_withheld(fix);
        judge(judged.waiting, judged.use);
        since_.back().barred = judged.barred;
        since_.back().outweighed = judged.outweighed;
    }
}

}  // namespace loopline::fusion
