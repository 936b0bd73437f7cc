#include "fusion/re_entry.h"

#include <algorithm>

namespace loopline::fusion {
namespace {

// What right ones that speak against the path have in common.
constexpr std::size_t agreement = 5;
constexpr double agreement_s = 3;
/// Where a vehicle stands a reflected signal stays as it is.
constexpr double agreement_way_m = 10;
/// If they are off by more than a path without fixes may come to, as a part of its way.
constexpr double long_agreement_s = 15, astray = 0.03, astray_by_slip = 1;

constexpr double at_least_part = 0.5, by_far = 1.5;  // of all since the first of them; and than any others
constexpr double rests_factor = 2;                   // for so many times as long as others spoke for the path
constexpr double same_sigmas = 4, same_part = 0.1;   // by which they may differ, of what they are off by
constexpr double comparable_sigma = 2;               // standard deviation of what counts beside a fix
constexpr double longest_apart_s = 1.5;              // of two fixes without a gap between
constexpr std::size_t most_lines = 50;

}  // namespace

void ReEntry::see(const Judged& fix, double for_s) {
    latest_.push_back(fix);
    while (seconds_between(latest_.front().stamp_ns, fix.stamp_ns) > for_s) latest_.pop_front();
}

void ReEntry::used(const Fix& fix, double after_s) {
    if (!latest_.empty())
        rests_on_s_ += std::min(longest_apart_s, seconds_between(latest_.back().stamp_ns, fix.stamp_ns));
    see({fix, true}, after_s);
    last_used_ = fix;
}

ReEntry::Verdict ReEntry::refused(const Fix& fix, const Eigen::Vector3d& off_m, double after_s) {
    if (fix.wheels_lead) after_s = std::min(after_s, long_agreement_s);
    see({fix, false, off_m}, after_s);
    const Against against = against_the_path(after_s);
    if (against.span_s == 0) return Verdict::path_holds;
    const bool was_wrong = against.span_s > by_far * rests_on_s_;
    begin(fix.stamp_ns, fix.way_m);
    rests_on_s_ = against.part * against.span_s;
    if (was_wrong) return Verdict::path_was_wrong;
    return against.too_far ? Verdict::contradiction : Verdict::path_drifted;
}

bool ReEntry::outweighs(double others_s) const {
    return rests_on_s_ > by_far * others_s;
}

void ReEntry::begin(StampNs stamp_ns, double way_m) {
    latest_.clear();
    begun_ = last_used_ = {stamp_ns, way_m};
    rests_on_s_ = 0;
}

/// The largest group of fixes beside those on the line that are off by the same; those that were used are
/// one.
std::size_t ReEntry::most_others(const std::function<bool(const Judged&)>& is_on_line) const {
    std::size_t most = 0;
    const std::size_t stride = 1 + latest_.size() / most_lines;
    for (std::size_t k = 0; k < latest_.size(); k += stride) {
        const Judged& middle = latest_[k];
        if (is_on_line(middle)) continue;
        std::size_t same = 0;
        for (const Judged& fix : latest_)
            same += !is_on_line(fix) &&
                            (fix.off_m - middle.off_m).norm() < same_sigmas * (fix.sigma_m + middle.sigma_m)
                        ? 1
                        : 0;
        most = std::max(most, same);
    }
    return most;
}

/// What the newest fix is off by and an earlier one was lies on a line in time: a path that is astray goes on
/// so. Where that line comes from where the last fix was used, it is drift from there on, and those that were
/// used before do not contradict it; a reflection begins with a jump. How many others does the line explain,
/// if they are to be believed, and for how long were they there?
ReEntry::Against ReEntry::against_the_path(double after_s) const {
    const Judged& newest = latest_.back();
    const double off_m = newest.off_m.norm();
    const auto ago_s = [&](const Fix& fix) { return seconds_between(fix.stamp_ns, newest.stamp_ns); };
    const auto counts = [&](const Fix& fix) { return fix.sigma_m <= comparable_sigma * newest.sigma_m; };
    Fix used = begun_;
    for (const Judged& fix : latest_)
        if (fix.used && counts(fix)) used = fix;
    if (counts(last_used_)) used = last_used_;

    const double may_be_off = newest.wheels_lead ? astray_by_slip : astray;
    const bool may_be_drift = off_m < may_be_off * (newest.way_m - used.way_m);
    const double wanted_s = std::min(after_s, std::max(rests_factor * rests_on_s_, long_agreement_s)),
                 least_s = may_be_drift ? agreement_s : std::min(long_agreement_s, wanted_s);
    const std::size_t stride = 1 + latest_.size() / most_lines;
    for (std::size_t first = 0; first < latest_.size(); first += stride) {
        const Judged& early = latest_[first];
        const double span_s = ago_s(early);
        if (early.used || !counts(early) || newest.way_m - early.way_m < agreement_way_m) continue;
        const Eigen::Vector3d per_s = (early.off_m - newest.off_m) / span_s;
        const double off_at_used_m = (newest.off_m + ago_s(used) * per_s).norm();
        const bool drifts = may_be_drift && span_s <= ago_s(used) &&
                            off_at_used_m < same_sigmas * newest.sigma_m + same_part * off_m;
        if (span_s < (drifts ? agreement_s : ago_s(used) < wanted_s ? wanted_s : least_s)) continue;
        const auto is_on_line = [&](const Judged& fix) {
            const Eigen::Vector3d beside_m = fix.off_m - newest.off_m - ago_s(fix) * per_s;
            const double sigma_m = counts(fix) ? fix.white_m : fix.sigma_m;
            return !(fix.used && counts(fix)) && beside_m.norm() < same_sigmas * sigma_m + same_part * off_m;
        };
        std::size_t all = 0, on_line = 0;
        for (std::size_t i = first; i < latest_.size(); ++i) {
            all += counts(latest_[i]) ? 1 : 0;
            on_line += counts(latest_[i]) && is_on_line(latest_[i]) ? 1 : 0;
        }
        const double part = static_cast<double>(on_line) / static_cast<double>(all);
        if (on_line < agreement || part < at_least_part) continue;
        if (drifts || static_cast<double>(on_line) >= by_far * static_cast<double>(most_others(is_on_line)))
            return {span_s, part, !drifts && early.off_m.norm() > may_be_off * (early.way_m - used.way_m)};
    }
    return {};
}

}  // namespace loopline::fusion
