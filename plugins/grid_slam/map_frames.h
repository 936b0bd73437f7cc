/// The scans that make the map, and where each of them was taken.
#pragma once

#include <cstdint>
#include <vector>

#include "api/pose2.h"
#include "api/stamp.h"
#include "grid_slam/frame_list.h"
#include "grid_slam/motion.h"

namespace loopline::grid_slam {

/// Frames by index; all vectors are of one length.
struct MapFrames {
    FrameList frames;
    std::vector<Pose2> poses;          ///< T_map_base
    std::vector<double> path_m;        ///< way of the vehicle when it was taken
    std::vector<std::uint64_t> scans;  ///< which scan of the log it was
    std::vector<StampNs> stamps_ns;
    std::vector<Motion> motions;  ///< from the frame before, as navigation tells it without scans

    std::size_t size() const { return frames.size(); }
    std::uint32_t last() const { return static_cast<std::uint32_t>(frames.size() - 1); }
    std::uint32_t add(const grid_map::Frame& frame, const Pose2& T_map_base, double way_m, std::uint64_t scan,
                      StampNs stamp_ns, const Motion& motion) {
        frames.push_back(frame);
        poses.push_back(T_map_base);
        path_m.push_back(way_m);
        scans.push_back(scan);
        stamps_ns.push_back(stamp_ns);
        motions.push_back(motion);
        return last();
    }
    double distance_m(std::uint32_t a, std::uint32_t b) const {
        return (poses[a].translation() - poses[b].translation()).norm();
    }
    double turn_rad(std::uint32_t a, std::uint32_t b) const {
        return std::abs(wrap_to_pi(poses[a].phi_rad - poses[b].phi_rad));
    }
};

}  // namespace loopline::grid_slam
