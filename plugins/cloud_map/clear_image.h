/// Of which parts of space a view can't say that it looked through them: asked about a whole box at once.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "cloud_map/range_view.h"

namespace loopline::cloud_map {

/// A cell for each pair of neighbouring rings and three columns: how far all of their beams went on. Through
/// a place that is farther away the view did not look. So if a box is beyond the farthest of the cells that
/// it may be in, none of its places was looked through; that is how a hierarchical z-buffer (Greene, Kass,
/// Miller 1993) leaves out what is hidden.
class ClearImage {
 public:
    ClearImage() = default;
    explicit ClearImage(const RangeView& view);

    /// False only if `view`, of which this was made, looked through no place of a box: RangeView::look()
    /// says `through` of none. `middle_m` from its origin and `half_m`, half of the edges, in the map's axes.
    bool may_look_through(const RangeView& view, const Eigen::Vector3f& middle_m,
                          const Eigen::Vector3f& half_m, const ViewSettings& settings) const;

 private:
    /// Where a box is for a lidar; bounds of all its places.
    struct Window {
        float turns, half_turns;  ///< azimuth, as part of a turn
        float level_min_m, level_max_m, z_min_m, z_max_m;
        /// Of the view's sectors, a bit each.
        std::uint64_t sectors() const;
    };
    static Window window_of(const Eigen::Matrix3f& R_lidar_map, const Eigen::Vector3f& middle_m,
                            const Eigen::Vector3f& half_m);
    bool may_look_through(const RangeView& view, const Window& window, const ViewSettings& settings) const;
    /// Whether a cell of a row is beyond `range`, in the view's unit; in columns from `first` to `last`,
    /// which may go over the end of the turn.
    bool any_beyond(int row, int first, int last, int range) const;

    static constexpr int group = 8;  ///< columns
    int columns_ = 0, groups_ = 0;
    std::vector<std::uint16_t> clear_;     ///< row by row, in the view's unit; 0: nothing came back
    std::vector<std::uint16_t> farthest_;  ///< of each group of a row
};

}  // namespace loopline::cloud_map
