/// What a break between two observations must keep.
#include "api/state_archive.h"
#include "fusion/fusion_module.h"

namespace loopline {

template <class Archive>
void fields(Archive& archive, Twist2& twist) {
    archive(twist.forward_m, twist.left_m, twist.turn_rad);
}

namespace gnss {

template <class Archive>
void fields(Archive& archive, Geodetic& place) {
    archive(place.latitude_deg, place.longitude_deg, place.height_m);
}

template <class Archive>
void fields(Archive& archive, GnssFix& fix) {
    archive(fix.stamp_ns, fix.received_ns, fix.utc_ns, fix.quality, fix.antenna, fix.has_position,
            fix.has_height, fix.geoid_separation_m, fix.satellites, fix.hdop, fix.vdop, fix.sigma_enu_m,
            fix.speed_mps, fix.course_rad, fix.heading_rad, fix.p_base_antenna_m);
}

template <class Archive>
void fields(Archive& archive, SigmaOfFix& sigma) {
    archive(sigma.white_m, sigma.correlated_m, sigma.correlation_s);
}

}  // namespace gnss

namespace fusion {

template <class Archive>
void fields(Archive& archive, Motion& motion) {
    archive(motion.T_from_to, motion.covariance);
}

template <class Archive>
void fields(Archive& archive, FixErrorProcess& process) {
    archive(process.correlation_s, process.sigma_m);
}

template <class Archive>
void fields(Archive& archive, WheelUse& use) {
    archive(use.used, use.slipped, use.sum_of_squares);
}

template <class Archive>
void fields(Archive& archive, Upright& upright) {
    archive(upright.R_level_odom.coeffs(), upright.covariance_rad2);
}

template <class Archive>
void fields(Archive& archive, Gap& gap) {
    archive(gap.from_ns, gap.to_ns, gap.end_pose, gap.way_m, gap.end_m, gap.dead_reckoned_end_m, gap.sigma_m);
}

template <class Archive>
void fields(Archive& archive, SeenFix& fix) {
    archive(fix.time_s, fix.p_local_m, fix.p_enu_m, fix.sigma);
}

template <class Archive>
void fields(Archive& archive, EarthState& state) {
    archive(state.T_enu_base, state.fix_error_m, state.wheel_errors, state.antenna_off_m, state.covariance);
}

template <class Archive>
void fields(Archive& archive, ReEntry& re_entry) {
    archive.each(re_entry.latest_, [](Archive& a, ReEntry::Judged& fix) {
        a(fix.stamp_ns, fix.way_m, fix.sigma_m, fix.white_m, fix.wheels_lead, fix.used, fix.off_m);
    });
    for (ReEntry::Fix* fix : {&re_entry.begun_, &re_entry.last_used_})
        archive(fix->stamp_ns, fix->way_m, fix->sigma_m, fix->white_m, fix->wheels_lead);
    archive(re_entry.rests_on_s_);
}

template <class Archive>
void fields(Archive& archive, HeadingStart& start) {
    archive(start.seen_);
}

template <class Archive>
void common(Archive& archive, std::optional<gnss::LocalFrame>& earth, HeadingFound& heading,
            std::array<std::size_t, fix_uses>& uses, WheelUse& wheels) {
    std::optional<gnss::Geodetic> origin;
    if (earth) origin = earth->origin();
    archive(origin);
    if (Archive::reading && origin) earth.emplace(*origin);
    archive(heading.way_m, heading.sigma_rad, wheels);
    for (auto& count : uses) archive(count);
}

template <class Archive>
void fields(Archive& archive, EarthPath& path) {
    common(archive, path.earth_, path.heading_, path.count_, path.wheel_use_);
    archive(path.dropped_, path.first_ns_);
    archive.each(path.poses_, [](Archive& a, EarthPath::PoseNode& node) {
        a(node.stamp_ns, node.T_odom_base, node.covariance, node.wheels, node.by_wheels, node.way_m,
          node.upright);
    });
    archive.each(path.waiting_, [](Archive& a, EarthPath::WaitingFix& w) { a(w.fix, w.withheld); });
    archive(path.early_, path.start_);
    std::optional<std::uint64_t> committed = path.committed_;
    archive(committed);
    if (Archive::reading && committed) path.committed_ = *committed;
    archive(path.state_, path.ahead_, path.latest_motion_, path.upright_, path.fix_process_, path.process_);
    archive(path.re_entry_, path.used_ns_, path.steps_, path.recent_steps_);
    archive(path.gaps_, path.used_.T_enu_base, path.used_.T_odom_base, path.used_.way_m);
    archive.each(path.footholds_, [](Archive& a, EarthPath::Foothold& then) {
        a(then.committed, then.steps, then.fixes, then.state, then.without, then.contradicted_m,
          then.rested_s, then.heading_holds, then.agrees_ns, then.agreeing, then.re_entry, then.fix_process,
          then.process, then.used_ns, then.gaps, then.used.T_enu_base, then.used.T_odom_base, then.used.way_m,
          then.sum_of_squares, then.squares);
    });
    archive.each(path.since_, [](Archive& a, EarthPath::JudgedFix& judged) {
        a(judged.waiting.fix, judged.waiting.withheld, judged.use, judged.barred, judged.outweighed);
    });
    archive(path.sum_of_squares_, path.squares_, path.re_entries_);
}

template <class Archive>
void fields(Archive& archive, PaperFilter& filter) {
    archive(filter.s_, filter.P_);
}

template <class Archive>
void fields(Archive& archive, PaperPath& path) {
    common(archive, path.earth_, path.heading_, path.count_, path.wheel_use_);
    archive.each(path.frames_, [](Archive& a, PaperPath::Frame& frame) {
        a(frame.stamp_ns, frame.T_odom_base, frame.wheels);
    });
    archive(path.first_ns_, path.way_m_, path.waiting_, path.start_, path.early_, path.begun_);
    for (PaperPath::Step* step : {&path.step_, &path.ahead_})
        archive(step->filter, step->way_m, step->turn_rad);
    archive(path.fused_, path.done_);
}

}  // namespace fusion

template <class Archive>
void fields(Archive& archive, FusionModule& m) {
    if (m.paper_ != nullptr) archive(*m.paper_);
    if (m.error_state_ != nullptr) archive(*m.error_state_);
    bool waits = m.waiting_.has_value();
    archive(waits);
    if (waits) {
        if constexpr (Archive::reading) m.waiting_ = std::pair<FusionModule::Moment, PoseWithCovariance>();
        auto& [moment, pose] = *m.waiting_;
        archive(moment.sequence, moment.stamp_ns, moment.timestamp, pose);
    }
    bool has_upright = m.upright_.has_value();
    archive(has_upright);
    if (has_upright) {
        if constexpr (Archive::reading) m.upright_ = std::pair<StampNs, fusion::Upright>();
        archive(m.upright_->first, m.upright_->second);
    }
    archive(m.last_, m.last_ns_, m.first_ns_, m.wheel_path_, m.wheel_readings_, m.T_odom_calibrated_,
            m.fused_odometry_, m.online_, m.backwards_, m.not_finite_, m.fixes_, m.geoid_separation_m_,
            m.p_base_antenna_m_, m.fixes_of_others_, m.fixes_came_);
}

void FusionModule::save_state(mrpt::serialization::CArchive& out) const {
    write_state(out, info().name, 9, *this);
}

void FusionModule::load_state(mrpt::serialization::CArchive& in) {
    read_state(in, info().name, 9, *this);
}

}  // namespace loopline
