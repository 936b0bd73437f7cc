/// What of module "grid_slam" goes into a checkpoint, class by class.
#include "grid_slam/grid_slam_module.h"
#include "grid_slam/navigation_state.h"

namespace loopline {
namespace {
constexpr std::uint32_t form_version = 6;
}

namespace grid_slam {

template <class Archive>
void fields(Archive& archive, FrameList& frames) {
    archive(frames.points_, frames.end_, frames.p_base_sensor_m_);
}

template <class Archive>
void fields(Archive& archive, MapFrames& map) {
    archive(map.frames, map.poses, map.path_m, map.scans, map.stamps_ns, map.motions);
}

template <class Archive>
void fields(Archive& archive, PosesAside& part) {
    archive(part.first, part.count);
}

template <class Archive>
void fields(Archive& archive, Constraint& c) {
    archive(c.from, c.to, c.T_from_to, c.information, c.kind);
}

template <class Archive>
void fields(Archive& archive, Linker& linker) {
    archive(linker.known_, linker.tried_);
}

template <class Archive>
void fields(Archive& archive, LoopRecord& r) {
    archive(r.frame, r.old_frame, r.way_m, r.likelihood, r.fit, r.rival, r.shift, r.sigma_m, r.sigma_rad,
            r.decision, r.reason);
}

template <class Archive>
void fields(Archive& archive, LoopSearch& search) {
    archive(search.looked_at_m_, search.known_at_m_, search.largest_sigma_m_, search.pending_,
            search.records_);
}

template <class Archive>
void fields(Archive& archive, LoopDecisions& decisions) {
    archive.each(decisions.named_,
                 [](auto& a, auto& named) { a(named.old_frame, named.reached, named.record); });
    archive(decisions.started_, decisions.first_ns_, decisions.last_ns_);
}

/// The grid is drawn anew: it is made of whole numbers, so the order does not matter.
template <class Archive>
void fields(Archive& archive, ActiveMap& active, const MapFrames& map) {
    archive(active.active_, active.T_grid_base_);
    if constexpr (Archive::reading) {
        active.in_grid_.assign(map.size(), false);
        for (const std::uint32_t frame : active.active_) {
            active.in_grid_[frame] = true;
            active.grid_.insert(map.frames[frame], active.T_grid_base_[frame]);
        }
    }
}

/// A correction works on the first of the constraints.
template <class Archive>
void fields(Archive& archive, std::optional<GraphOptimiser>& correction,
            const std::vector<Constraint>& constraints, const GraphSettings& settings) {
    bool there = correction.has_value();
    archive(there);
    if (!there) return;
    std::vector<Pose2> poses;
    std::uint64_t used = 0;
    int iterations = 0;
    bool good = true;
    if constexpr (!Archive::reading) {
        poses = correction->poses();
        used = correction->constraints();
        iterations = correction->iterations();
        good = correction->good();
    }
    archive(poses, used, iterations, good);
    if constexpr (Archive::reading) {
        correction.emplace(poses,
                           std::vector<Constraint>(constraints.begin(),
                                                   constraints.begin() + static_cast<std::ptrdiff_t>(used)),
                           settings);
        correction->go_on_from(iterations, good);
    }
}

template <class Archive>
void fields(Archive& archive, GridSlam& slam) {
    archive(slam.map_);
    fields(archive, slam.active_, slam.map_);
    archive(slam.linker_, slam.loops_, slam.decisions_, slam.found_, slam.constraints_);
    archive(slam.places_);
    if (Archive::reading && !slam.places_.empty()) slam.latest_ = slam.places_.back();
    archive(slam.since_frame_, slam.since_last_frame_, slam.stamp_ns_, slam.way_m_, slam.chosen_at_m_);
    fields(archive, slam.correction_, slam.constraints_, slam.settings_.online_graph);
    std::uint64_t correction_frames = slam.correction_frames_;
    archive(correction_frames, slam.relink_after_, slam.loop_, slam.unmatched_, slam.degenerate_,
            slam.motions_refused_);
    archive(slam.correction_poses_);
    archive.each(slam.corrections_, [](auto& a, auto& c) {
        a(c.stamp_ns, c.old_frame, c.frame, c.before, c.after, c.reverse_first, c.reverse, c.T_before_after);
    });
    slam.correction_frames_ = correction_frames;
    if constexpr (Archive::reading) slam.rebuild_neighbourhood();
}

template void fields(StateWriter&, GridSlam&);
template void fields(StateReader&, GridSlam&);

}  // namespace grid_slam

template <class Archive>
void fields(Archive& archive, GridSlamModule& m) {
    archive(*m.slam_);
    archive(m.scans_);
    archive(m.online_);
}

void GridSlamModule::save_state(mrpt::serialization::CArchive& out) const {
    write_state(out, info().name, form_version, *this);
}

void GridSlamModule::load_state(mrpt::serialization::CArchive& in) {
    read_state(in, info().name, form_version, *this);
}

}  // namespace loopline
