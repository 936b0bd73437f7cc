/// The part of the map that is safe to match with: frames whose place is well known from where the vehicle is
/// now. What it saw long ago, and may be off by more than a wall's thickness by now, is not part of it until
/// a loop is closed.
#pragma once

#include <vector>

#include "grid_map/scan_grid.h"
#include "grid_slam/map_frames.h"
#include "grid_slam/relative_uncertainty.h"

namespace loopline::grid_slam {

struct ActiveMapSettings {
    double sigma_m = 0.12;  ///< how well the place of a frame must be known
    double radius_m = 25;   ///< how near it must be
    double moved_m = 0.01;  ///< a frame whose pose was corrected by more is drawn anew
    double moved_rad = 0.003;
};

class ActiveMap {
 public:
    ActiveMap(const grid_map::ScanGridSettings& grid, const ActiveMapSettings& settings)
        : settings_(settings), grid_(grid) {}

    const grid_map::ScanGrid& grid() const { return grid_; }
    bool is_active(std::uint32_t frame) const { return frame < in_grid_.size() && in_grid_[frame]; }
    /// Of all frames, in ascending order.
    const std::vector<std::uint32_t>& active() const { return active_; }

    /// A new frame, which is known from where the vehicle is.
    void add(const MapFrames& map, std::uint32_t frame);
    /// Chooses anew from what is known from frame `from`.
    void choose(const MapFrames& map, const Neighbourhood& neighbourhood, std::uint32_t from);

 private:
    template <class Archive>
    friend void fields(Archive&, ActiveMap&, const MapFrames&);
    void draw(const MapFrames& map, std::uint32_t frame);
    void wipe(const MapFrames& map, std::uint32_t frame);
    bool has_moved(const MapFrames& map, std::uint32_t frame) const;

    ActiveMapSettings settings_;
    grid_map::ScanGrid grid_;
    std::vector<bool> in_grid_;
    std::vector<Pose2> T_grid_base_;  ///< where a frame was drawn
    std::vector<std::uint32_t> active_;
    RelativeUncertainty uncertainty_;
};

}  // namespace loopline::grid_slam
