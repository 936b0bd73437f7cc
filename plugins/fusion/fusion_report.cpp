/// What module "fusion" hands over at the end of a run: figures, the path's inputs, its place on the Earth.
#include <algorithm>
#include <cmath>

#include "fusion/fix_lag.h"
#include "fusion/fusion_module.h"
#include "inertial/words.h"

namespace loopline {

using namespace fusion;

namespace {
constexpr double least_gap_way_m = 20;  // of which a part of the way makes sense
constexpr std::size_t most_told_gaps = 99;
/// More than such a part of all fixes with a position is not reflected.
constexpr double off_too_often = 0.4;
constexpr double lag_matters_s = 0.05, lag_is_certain = 5;  // standard deviations
}  // namespace

/// What the path was made from, for who wants to compare: the motion alone, from the first pose on, and the
/// fixes.
void FusionModule::hand_over_inputs(const Pose3& T_enu_base_first, Results& results) const {
    const Pose3 T_enu_odom = T_enu_base_first * online_.front().T_odom_base.pose().inverse();
    auto motion = std::make_shared<Trajectory>();
    motion->keep_in(scratch_folder_);
    for (const Online& online : online_)
        motion->append(online.sequence, online.stamp_ns, T_enu_odom * online.T_odom_base.pose(), {});
    results.uncorrected = NamedPath{"without fixes", motion};
    results.fixes.list = &fixes_;
    for (std::size_t use = 0; use < fix_uses; ++use)
        results.fixes.fates.push_back(name_of(static_cast<FixUse>(use)));
}

void FusionModule::report(Results& results) const {
    auto& metrics = results.metrics;
    const auto count = [&](FixUse use) { return static_cast<std::int64_t>(path_->count(use)); };
    std::int64_t refused = 0;
    for (std::size_t i = 1; i < fix_uses; ++i) {
        const auto use = static_cast<FixUse>(i);
        refused += count(use);
        if (count(use) > 0) metrics[std::string("gnss_refused_") + name_of(use)] = count(use);
    }
    if (backwards_ > 0) metrics["poses_backward"] = backwards_;
    if (not_finite_ > 0) metrics["poses_not_finite"] = not_finite_;
    report_what_never_came(results);
    report_wheels(results);
    report_gaps(results);
    report_lag(results);
    metrics["gnss_used"] = count(FixUse::used);
    metrics["gnss_refused"] = refused;
    if (!path_->known()) {
        results.warnings.push_back(
            "the fixes of the receiver never told the heading of the path, so it is not placed on the Earth; "
            "its frame is that of " +
            (motion_label_.empty() ? told_wheels_label_ : motion_label_));
        return;
    }
    const gnss::Geodetic& origin = path_->earth()->origin();
    results.earth =
        EarthFrame{origin.latitude_deg, origin.longitude_deg, origin.height_m, 0, geoid_separation_m_};
    metrics["heading_found_way_m"] = path_->heading().way_m;
    metrics["heading_found_sigma_deg"] = path_->heading().sigma_rad * 180 / M_PI;
    if (paper_ != nullptr) metrics["frames_fused"] = static_cast<std::int64_t>(paper_->fused());
    report_fixes(results);
    if (error_state_ == nullptr) return;
    metrics["gnss_re_entries"] = static_cast<std::int64_t>(error_state_->re_entries());
    metrics["gnss_mean_square"] = error_state_->mean_square();
    if (settings_.sigma_antenna_m > 0) {
        metrics["antenna_forward_off_m"] = error_state_->antenna_off_m().x();
        metrics["antenna_left_off_m"] = error_state_->antenna_off_m().y();
    }
}

/// A label that nothing has is a slip of the pen, or the log is another one.
void FusionModule::report_what_never_came(Results& results) const {
    if (fixes_of_others_ > 0) results.metrics["gnss_of_other_receivers"] = fixes_of_others_;
    if (fixes_came_ == 0 && fixes_of_others_ > 0)
        results.warnings.push_back("no receiver has the label " + receiver_label_ + ", others have sent " +
                                   std::to_string(fixes_of_others_) +
                                   " fixes; see `loopline check` for their labels, and [fusion] receiver");
    if (!told_wheels_label_.empty() && !motion_label_.empty() && wheel_readings_.taken() == 0)
        results.warnings.push_back("no wheel odometry with the label " + told_wheels_label_ +
                                   " came, so that the path goes on without wheels; see `loopline check` for "
                                   "the labels of the log, and [fusion] wheels");
}

void FusionModule::report_fixes(Results& results) const {
    const std::size_t off = path_->count(FixUse::off_the_path), used = path_->count(FixUse::used),
                      out_of_sync = path_->count(FixUse::out_of_sync);
    if (static_cast<double>(off) > off_too_often * static_cast<double>(off + used))
        results.warnings.push_back(
            std::to_string(off) + " of " + std::to_string(off + used) +
            " fixes contradict the path: they were reflected, or the motion is not what it says, as where "
            "wheels slip; where that is, earth_plan.png shows");
    if (out_of_sync > 0 && used == 0)
        results.warnings.push_back(
            "no frame had a fix and all that [fusion] names within sync_s of it, so that the path goes on by "
            "the motion alone; see sync_s, and sync = interpolate");
}

void FusionModule::report_wheels(Results& results) const {
    if (told_wheels_label_.empty()) return;
    auto& metrics = results.metrics;
    using Verdict = WheelReadings::Verdict;
    metrics["wheel_readings"] = wheel_readings_.count(Verdict::good);
    for (const auto& [verdict, reason] :
         {std::pair(Verdict::backward, "backward"), std::pair(Verdict::not_finite, "not_finite"),
          std::pair(Verdict::implausible, "implausible")})
        if (wheel_readings_.count(verdict) > 0)
            metrics[std::string("wheels_refused_") + reason] = wheel_readings_.count(verdict);
    if (error_state_ == nullptr) return;
    if (!motion_label_.empty()) {
        metrics["wheels_used"] = static_cast<std::int64_t>(path_->wheel_use().used);
        metrics["wheels_mean_square"] = path_->wheel_use().mean_square();
        metrics["wheels_refused_slipped"] = static_cast<std::int64_t>(path_->wheel_use().slipped);
    }
    const auto& errors = error_state_->wheel_errors();
    const auto sigmas = error_state_->wheel_error_sigmas();
    metrics["wheel_scale"] = 1 + errors[way_scale];
    metrics["wheel_scale_sigma"] = sigmas[way_scale];
    metrics["wheel_turn_scale"] = 1 + errors[turn_scale];
    metrics["wheel_turn_scale_sigma"] = sigmas[turn_scale];
    metrics["wheel_bend_deg"] = errors[bend] * 180 / M_PI;
    metrics["wheel_bend_sigma_deg"] = sigmas[bend] * 180 / M_PI;
    metrics["wheel_one_sided"] = errors[one_sided];
    metrics["wheel_curve_m2"] = errors[curve];
}

/// How far, on the plan, the path was at the end of each gap from where the fixes after it have put it, and
/// its motion alone from where the gap began.
void FusionModule::report_gaps(Results& results) const {
    if (withhold_s_ == 0 || error_state_ == nullptr) return;
    const auto& gaps = error_state_->gaps();
    results.metrics["gaps"] = static_cast<std::int64_t>(gaps.size());
    const auto sum_up = [&](const std::string& of, Eigen::Vector3d Gap::*off) {
        double squares = 0, worst_m = 0, parts = 0, worst_part = 0;
        std::size_t moving = 0;
        for (const Gap& gap : gaps) {
            const double off_m = (gap.*off).head<2>().norm();
            squares += off_m * off_m;
            worst_m = std::max(worst_m, off_m);
            if (gap.way_m < least_gap_way_m) continue;
            ++moving;
            parts += off_m / gap.way_m;
            worst_part = std::max(worst_part, off_m / gap.way_m);
        }
        if (gaps.empty()) return;
        results.metrics["gap_end_" + of + "rmse_m"] = std::sqrt(squares / static_cast<double>(gaps.size()));
        results.metrics["gap_end_" + of + "worst_m"] = worst_m;
        if (moving == 0) return;
        results.metrics["gap_end_" + of + "mean_percent"] = 100 * parts / static_cast<double>(moving);
        results.metrics["gap_end_" + of + "worst_percent"] = 100 * worst_part;
    };
    for (std::size_t i = 0; i < gaps.size() && i < most_told_gaps; ++i) {
        const Gap& gap = gaps[i];
        const std::string key = "gap_" + std::string(i < 9 ? "0" : "") + std::to_string(i + 1) + "_";
        results.metrics[key + "from_s"] = seconds_between(first_ns_, gap.from_ns);
        results.metrics[key + "to_s"] = seconds_between(first_ns_, gap.to_ns);
        results.metrics[key + "way_m"] = gap.way_m;
        results.metrics[key + "error_m"] = gap.off_m.head<2>().norm();
        results.metrics[key + "sigma_m"] = gap.sigma_m.head<2>().norm();
        results.metrics[key + "dead_reckoning_m"] = gap.dead_reckoning_off_m.head<2>().norm();
    }
    sum_up("error_", &Gap::off_m);
    sum_up("dead_reckoning_", &Gap::dead_reckoning_off_m);
}

/// Fixes whose stamps are off contradict the path wherever its speed changes, and are refused there.
void FusionModule::report_lag(Results& results) const {
    if (!p_base_antenna_m_) return;
    std::vector<PlaceAt> path, fixes;
    online_.for_each(0, online_.size(), [&](const Online& pose) {
        path.push_back({seconds_between(first_ns_, pose.stamp_ns),
                        (pose.T_odom_base.pose() * *p_base_antenna_m_).head<2>()});
    });
    fixes_.for_each(0, fixes_.size(), [&](const PlacedFix& fix) {
        fixes.push_back({seconds_between(first_ns_, fix.stamp_ns),
                         Eigen::Map<const Eigen::Vector2d>(fix.p_map_m.data())});
    });
    std::sort(fixes.begin(), fixes.end(),
              [](const PlaceAt& a, const PlaceAt& b) { return a.time_s < b.time_s; });
    const auto lag = lag_of_fixes(path, fixes);
    if (!lag) return;
    results.metrics["gnss_lag_s"] = lag->lag_s;
    results.metrics["gnss_lag_sigma_s"] = lag->sigma_s;
    if (std::abs(lag->lag_s) < std::max(lag_matters_s, lag_is_certain * lag->sigma_s)) return;
    results.warnings.push_back(
        "the stamps of the fixes are " + inertial::decimals(std::abs(lag->lag_s), 2) + " s " +
        (lag->lag_s > 0 ? "late" : "early") + " against the motion (standard deviation " +
        inertial::digits(lag->sigma_s, 2) + " s, by " + std::to_string(lag->stretches) +
        " stretches of the path); set [fusion] latency_s = " +
        inertial::decimals(latency_s_ + lag->lag_s, 2));
}

}  // namespace loopline
