/// What of module "line_slam" goes into a checkpoint, class by class.
#include "api/state_archive.h"
#include "line_slam/ekf_state.h"
#include "line_slam/line_slam_module.h"
#include "lines/observation_lines.h"

namespace loopline {
namespace {
constexpr std::uint32_t form_version = 3;
}

namespace line_slam {

template <class Archive>
void fields(Archive& archive, Extent& extent) {
    archive(extent.from_m, extent.to_m);
}

template <class Archive>
void fields(Archive& archive, LineObservation& z) {
    archive(z.line, z.covariance, z.wall_covariance, z.surplus, z.start_m, z.end_m);
}

template <class Archive>
void fields(Archive& archive, MapLineRecord& r) {
    archive(r.extent, r.track, r.observations, r.last_seen_m, r.places, r.awake, r.recent);
}

template <class Archive>
void fields(Archive& archive, LineGrid& grid) {
    archive(grid.cells_);
}

template <class Archive>
void fields(Archive& archive, TentativeLine& t) {
    archive(t.latest, t.extent, t.drift, t.track, t.scans, t.last_scan);
}

template <class Archive>
void fields(Archive& archive, TentativeLines& tentative) {
    archive(tentative.lines_);
}

template <class Archive>
void fields(Archive& archive, WheelTravel& travel) {
    archive(travel.left_m, travel.right_m, travel.side_m);
}

template <class Archive>
void fields(Archive& archive, HistoryStep& step) {
    archive(step.travel, step.travel_covariance, step.T_map_base, step.observations, step.tracks);
}

/// The drive is a parameter.
template <class Archive>
void fields(Archive& archive, History& history) {
    archive(history.steps, history.track_count, history.same_wall, history.calibration);
}

template <class Archive>
void fields(Archive& archive, LineSlamCounts& c) {
    archive(c.updates, c.predictions, c.associations, c.rejected, c.merged, c.recognised, c.refused, c.slips,
            c.dropped);
}

template <class Archive>
void fields(Archive& archive, LineEkfSlam& slam) {
    archive(slam.filter_, slam.records_, slam.tentative_, slam.history_, slam.counts_);
    archive(slam.awake_, slam.young_, slam.lines_at_, slam.grid_);
    archive(slam.path_m_, slam.recognised_at_m_, slam.woken_at_m_, slam.last_pairings_, slam.scan_,
            slam.active_limit_);
}

template <class Archive>
void fields(Archive& archive, WheelSpeed& speed) {
    archive(speed.left_mps, speed.right_mps);
}

template <class Archive>
void fields(Archive& archive, RegimeWatch& watch) {
    archive(watch.regime_);
}

template <class Archive>
void fields(Archive& archive, WideInterval& interval) {
    auto& i = interval;
    archive(i.watch_, i.regime_, i.regime_at_step_, i.speed_at_step_, i.begun_);
    Pose2 T_step_odom = i.T_step_odom_.pose();
    archive(i.T_odom_base_, T_step_odom, i.T_step_base_, i.T_step_previous_);
    i.T_step_odom_ = PreparedPose2(T_step_odom);
    archive.each(i.stretches_, [](auto& a, auto& s) { a(s.regime, s.T_step_from, s.from_s); });
    archive(i.duration_s_, i.last_duration_s_, i.way_m_, i.scans_, i.re_predictions_);
}

}  // namespace line_slam

/// Lines that nobody has looked at yet are extracted for it: the module that would do so when they are wanted
/// may be in another process by then.
template <class Archive>
void fields(Archive& archive, std::shared_ptr<const CObservationLines>& lines) {
    bool there = lines != nullptr;
    archive(there);
    if (!there) return;
    if constexpr (Archive::reading)
        lines = archive.archive().template ReadObject<CObservationLines>();
    else
        archive.archive().WriteObject(*lines);
}

template <class Archive>
void fields(Archive& archive, LineSlam& module) {
    auto& m = module;
    const auto command = [](auto& a, auto& c) {
        bool there = c.has_value();
        a(there);
        if (Archive::reading && there) c = LineSlam::Command();
        if (there) a(c->regime, c->since_ns);
    };
    const auto scan = [&command](auto& a, auto& s) {
        a(s.sequence, s.stamp_ns, s.timestamp, s.T_odom_base);
        fields(a, s.lines);
        command(a, s.commanded);
    };
    archive(*m.slam_, *m.interval_);
    archive.each(m.waiting_, scan);
    archive(m.newest_lines_);
    bool since_step = m.since_step_.has_value();
    archive(since_step);
    if (Archive::reading && since_step) m.since_step_ = LineSlam::Scan();
    if (since_step) scan(archive, *m.since_step_);
    archive(m.T_odom_base_, m.since_previous_s_);
    command(archive, m.commanded_);
    archive.each(m.places_,
                 [](auto& a, auto& p) { a(p.sequence, p.stamp_ns, p.T_step_base, p.regime, p.is_step); });
    archive.each(m.steps_, [](auto& a, auto& step) { a(step.T_map_base, step.covariance); });
    archive(m.status_, m.without_odometry_);
}

void LineSlam::save_state(mrpt::serialization::CArchive& out) const {
    write_state(out, "line_slam", form_version, *this);
}

void LineSlam::load_state(mrpt::serialization::CArchive& in) {
    read_state(in, "line_slam", form_version, *this);
}

}  // namespace loopline
