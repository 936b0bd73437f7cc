/// What the filter knows of its map lines beside their state: where they were seen, how often and when.
#pragma once

#include <vector>

#include "line_slam/planar_line.h"

namespace loopline::line_slam {

struct MapLineRecord {
    Extent extent;            ///< seen part, along the line's tangent in the map frame
    int track = -1;           ///< in the history, for the smoother
    int observations = 0;     ///< scans that saw it
    double last_seen_m = 0;   ///< length of the path until then
    std::vector<int> places;  ///< where along the path it was seen, in whole metres, growing
    bool awake = true;        ///< seen lately, or near to what is seen: a scan may be matched with it
    bool recent = true;       ///< seen on the last metres of the path
};

/// By the filter's line id.
using MapLineRecords = std::vector<MapLineRecord>;

}  // namespace loopline::line_slam
