/// What of a path by sweeps goes into a checkpoint, class by class.
#pragma once

#include "api/state_archive.h"
#include "lidar_mapping/led_sweeps.h"
#include "lidar_mapping/sweep_mapping.h"

namespace loopline {
namespace lidar_mapping {

template <class Archive>
void fields(Archive& archive, SweepPoint& point) {
    archive(point.p_base_m, point.time_s, point.beam_base);
}

template <class Archive>
void fields(Archive& archive, MotionState& state) {
    archive(state.T_map_base, state.velocity, state.covariance, state.way_on_trust_m);
}

template <class Archive>
void fields(Archive& archive, SurfaceMap& map) {
    archive(map.sweeps_);
    for (auto& size : map.sizes_) {
        std::uint64_t slots = size.slots.size();
        std::uint32_t cells = size.cells;
        archive(slots, cells);
        if constexpr (Archive::reading) {
            size.cells = 0;
            size.pieces.clear();
            for (std::uint32_t k = 0; k < cells; ++k) SurfaceMap::append(size, 0);
        }
        for (std::uint32_t k = 0; k < cells; ++k) {
            SurfaceMap::Cell& c = size[k];
            archive(c.key, c.seen);
            for (auto& x : c.sum) archive(x);
            for (auto& x : c.squares) archive(x);
            archive(c.noise, c.sweeps);
            for (auto& x : c.direction) archive(x);
            for (auto& x : c.along) archive(x);
            archive(c.variance_m2, c.per_along_m2, c.per_beside_m2, c.returns, c.fitted, c.kind);
        }
        if constexpr (Archive::reading) SurfaceMap::make_slots(size, slots);
    }
}

template <class Archive>
void fields(Archive& archive, Standstill::Piece& piece) {
    archive(piece.n, piece.sum_m, piece.squares_m2);
}

template <class Archive>
void fields(Archive& archive, Standstill& standstill) {
    archive(standstill.learnt_, standstill.sweeps_);
    for (auto& sector : standstill.usual_) archive(sector.n, sector.sum, sector.squares);
}

template <class Archive>
void fields(Archive& archive, SweepMapping& mapping) {
    archive(mapping.map_, mapping.first_, mapping.first_middle_s_, mapping.last_.state,
            mapping.last_.by_prediction, mapping.covariance_, mapping.sweeps_, mapping.last_ns_,
            mapping.forgot_at_m_, mapping.added_at_, mapping.standstill_, mapping.stands_,
            mapping.usual_agreement_, mapping.speed_is_known_);
}

template <class Archive>
void fields(Archive& archive, PublishedOdometry& odometry) {
    archive.each(odometry.poses_,
                 [](auto& a, auto& pose) { a(pose.stamp_ns, pose.known.T_map_base, pose.known.covariance); });
    archive(odometry.planar_, odometry.taken_);
}

template <class Archive>
void fields(Archive& archive, LedSweeps& led) {
    archive(led.odometry_, led.unusable_, led.waits_);
    if (led.waits_) archive(led.now_.sequence, led.now_.stamp_ns, led.now_.timestamp, led.now_.scan);
}

}  // namespace lidar_mapping

namespace lidar {

template <class Archive>
void fields(Archive& archive, SpinningScan& scan) {
    archive(scan.label, scan.stamp_ns, scan.T_base_lidar, scan.begin_s, scan.end_s, scan.ring_begin);
    archive.each(scan.points, [](auto& a, auto& p) { a(p.x_m, p.y_m, p.z_m, p.time_s); });
}

}  // namespace lidar

}  // namespace loopline
