/// The scans that make the map, as a list that may lie on disk: they are most of the memory of a long run,
/// and few of them are in use at a time.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "api/set_aside.h"
#include "grid_map/frame.h"

namespace loopline::grid_slam {

class FrameList {
 public:
    /// Frames from now on go there; they stay in memory if the folder has no name. Only while there are none.
    void keep_in(const std::filesystem::path& folder) { points_.keep_in(folder, "grid_slam_frames"); }

    std::size_t size() const { return end_.size(); }
    void push_back(const grid_map::Frame& frame);
    /// Valid until others have been asked for.
    const grid_map::Frame& operator[](std::uint32_t index) const;

 private:
    template <class Archive>
    friend void fields(Archive&, FrameList&);
    /// A surface point: (x, y) and the normal, as in grid_map::SurfacePoint.
    using Point = std::array<float, 4>;
    struct Cached {
        std::uint32_t frame = 0;
        bool filled = false;
        grid_map::Frame content;
    };

    SetAside<Point> points_;          ///< of all frames, one after the other
    std::vector<std::uint64_t> end_;  ///< of each frame, in points_
    std::vector<Eigen::Vector2f> p_base_sensor_m_;
    static constexpr std::size_t cached_frames = 256;
    mutable std::vector<Cached> cache_;  ///< frame k at k % cached_frames
};

}  // namespace loopline::grid_slam
