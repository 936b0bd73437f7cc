#include "grid_slam/grid_slam_module.h"

#include <limits>

namespace loopline {
IMPLEMENTS_MRPT_OBJECT(GridSlamModule, Module, loopline)

namespace {

using namespace grid_slam;

std::vector<Eigen::Vector2f> points_of(const grid_map::Frame& frame) {
    std::vector<Eigen::Vector2f> points_m;
    points_m.reserve(frame.points.size());
    for (const grid_map::SurfacePoint& point : frame.points) points_m.push_back(point.p_base_m);
    return points_m;
}

}  // namespace

ModuleInfo GridSlamModule::info() const {
    ModuleInfo info{
        "grid_slam",
        "Maps with a planar laser on a grid, finds loops of the path by itself and corrects them.",
        {"CObservation2DRangeScan"},
        {},
        {"CObservationRobotPose"}};
    scans_.add_needs(info);
    return info;
}

void GridSlamModule::start(const RunContext& context) {
    fit_surfaces_to_noise(settings_.frame, settings_.forward.refinement.sigma_m);
    settings_.loops.cell_m = settings_.cell_m;
    settings_.loops.refinement = settings_.forward.refinement;
    settings_.links.refinement = settings_.forward.refinement;
    settings_.links.refinement.iterations = 15;
    settings_.links.refinement.give_up_fit = 0.3;
    if (!loops_) settings_.loops.every_m = std::numeric_limits<double>::infinity();
    settings_.decisions.named = named_loops_from_text(named_loops_);
    settings_.decisions.refused = refusals_from_text(refused_loops_);
    settings_.decisions.without_search = intervals_from_text(without_search_);
    slam_ = std::make_unique<GridSlam>(settings_);
    slam_->keep_in(context.scratch_folder);
    online_.keep_in(context.scratch_folder, "grid_slam_online");
    trajectory_.keep_in(context.scratch_folder);
    scans_.start(settings_.weights != Weights::joint);
    if (scans_.inertial() != nullptr)
        reverse_navigation_ = std::make_unique<InertialReverse>(*scans_.inertial(), slam_->map());
    slam_->set_reverse_navigation(reverse_navigation_.get());
}

void GridSlamModule::process(const StreamItem& item, Publisher& publisher) {
    scans_.take(item, [&](const NavigatedScans::Scan& scan) {
        estimate(scan, publisher);
        return !slam_->loop_at_hand();  // a state is kept in between
    });
}

void GridSlamModule::drain(Publisher& publisher) {
    scans_.drain([&](const NavigatedScans::Scan& scan) { estimate(scan, publisher); });
}

void GridSlamModule::estimate(const NavigatedScans::Scan& scan, Publisher& publisher) {
    const PlanarScan* beams = scans_.beams(scan);
    if (beams == nullptr) return;
    if (const auto T_new_old = slam_->advance()) scans_.move(*T_new_old);
    const Prediction prediction = scans_.predict(scan);
    const ScanPose pose = slam_->add(*beams, prediction, scans_.sweep(prediction));
    scans_.update(scan, pose.match);
    online_.push_back({scan.sequence, scan.stamp_ns, pose.T_map_base});
    const auto published = pose_observation(published_label, pose.T_map_base, pose.match.covariance);
    published->timestamp = scan.observation->timestamp;
    publisher.publish(published, scan.sequence);
}

void GridSlamModule::lay_out_trajectory() {
    std::size_t k = 0;
    for (const OnlinePose online : online_) {
        const GridSlam::KnownPose latest = slam_->latest(k++);
        trajectory_.append_revised(online.sequence, online.stamp_ns, Pose3(online.T_map_base),
                                   Pose3(latest.T_map_base), PoseCovariance::planar(latest.covariance));
    }
    trajectory_.finish_revision();
}

void GridSlamModule::report_loops(Results& results) const {
    std::int64_t accepted = 0, refused = 0;
    std::vector<LoopDecision> never_tried;
    for (const auto& [named, reason] : slam_->decisions().untried()) {
        LoopDecision loop;
        loop.stamp_ns = named->stamp_ns;
        loop.old_stamp_ns = named->old_stamp_ns;
        loop.reason = reason;
        ++refused;
        never_tried.push_back(std::move(loop));
    }
    for (const LoopRecord& record : slam_->loops()) {
        LoopDecision loop;
        loop.stamp_ns = online_[slam_->map().scans[record.frame]].stamp_ns;
        loop.old_stamp_ns = online_[slam_->map().scans[record.old_frame]].stamp_ns;
        loop.way_m = record.way_m;
        loop.score = record.likelihood;
        loop.rival_score = record.rival;
        loop.shift_m = record.shift.head<2>().norm();
        loop.shift_rad = record.shift.z();
        loop.sigma_m = record.sigma_m;
        loop.sigma_rad = record.sigma_rad;
        loop.accepted = record.decision == LoopRecord::Decision::accepted;
        loop.waits = record.decision == LoopRecord::Decision::waits;
        loop.reason = record.reason;
        (loop.accepted ? accepted : refused) += record.decision == LoopRecord::Decision::waits ? 0 : 1;
        results.loops.push_back(std::move(loop));
    }
    results.loops.insert(results.loops.end(), never_tried.begin(), never_tried.end());
    results.metrics["loops_found"] = accepted;
    results.metrics["loops_refused"] = refused;
    for (const Correction& c : slam_->corrections())
        if (c.before.count > 0)
            results.corrections.push_back({c.stamp_ns, c.old_frame, c.frame, c.T_before_after,
                                           slam_->poses_of(c.before), slam_->poses_of(c.after),
                                           c.reverse_first, slam_->poses_of(c.reverse)});
    PoseGraph graph;
    graph.poses = slam_->map().poses;
    graph.constraints.reserve(slam_->constraints().size());
    for (const Constraint& c : slam_->constraints())
        graph.constraints.push_back({c.from, c.to, c.T_from_to, c.information});
    results.pose_graph = std::move(graph);
}

void GridSlamModule::finish(Results& results) {
    slam_->finish();
    lay_out_trajectory();
    report_loops(results);
    if (!results.corrections.empty())
        results.frame_points_base_m = {slam_->map().size(), [&frames = slam_->map().frames](std::size_t i) {
                                           return points_of(frames[static_cast<std::uint32_t>(i)]);
                                       }};
    auto& metrics = results.metrics;
    metrics["corrections"] = static_cast<std::int64_t>(slam_->corrections().size());
    metrics["map_frames"] = static_cast<std::int64_t>(slam_->map().size());
    metrics["constraints"] = static_cast<std::int64_t>(slam_->constraints().size());
    metrics["scans_unmatched"] = static_cast<std::int64_t>(slam_->unmatched());
    metrics["motions_refused"] = static_cast<std::int64_t>(slam_->motions_refused());
    metrics["scans_degenerate"] = static_cast<std::int64_t>(slam_->degenerate());
    scans_.report(metrics);
}

}  // namespace loopline
