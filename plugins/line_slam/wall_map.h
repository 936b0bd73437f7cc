/// The walls that a history's pairings amount to, and how these pairings get better once the path is better:
/// what lies on one wall is one wall, and every observation is looked up again.
#pragma once

#include <vector>

#include "line_slam/history.h"

namespace loopline::line_slam {

/// Per step and observation: the track of its wall, or no_track.
using Pairings = std::vector<std::vector<int>>;

struct Wall {
    PlanarLine line;  ///< map frame
    Extent extent;
    int observations = 0;
    int track = no_track;
};

/// The history's own pairings, tracks that were recognised as one wall under one number.
Pairings filter_pairings(const History& history);

/// A value for each track: its latest observation as seen from `poses`.
std::vector<PlanarLine> latest_lines(const History& history, const std::vector<Pose2>& poses,
                                     const Pairings& pairings);

/// Walls with at least `min_observations`, ordered by track; extents by `poses`.
std::vector<Wall> walls_of(const History& history, const std::vector<Pose2>& poses, const Pairings& pairings,
                           const std::vector<PlanarLine>& line_of_track, int min_observations);

/// Which walls are one: those that overlap and lie within `distance_m` of one another over the shorter one's
/// length. Returns the track to use for every track; the wall with more observations keeps its own.
std::vector<int> merged_tracks(const std::vector<Wall>& walls, int track_count, double distance_m);

struct PairingParameters {
    double gate = 13.8;      ///< squared Mahalanobis distance of two degrees of freedom
    double max_gap_m = 1.0;  ///< between the seen part of a wall and the observation
};

/// Every observation's nearest wall within the gate. One that finds none keeps the wall that it had: the
/// robust loss decides what it is worth. Returns whether any pairing changed.
bool pair_again(const History& history, const std::vector<Pose2>& poses, const std::vector<Wall>& walls,
                const std::vector<int>& merged, const PairingParameters& parameters, Pairings& pairings);

}  // namespace loopline::line_slam
