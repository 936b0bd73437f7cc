/// What a user can set about line extraction; the module binds its .ini keys to this struct.
#pragma once

#include <cmath>

namespace loopline::lines {

enum class Method { angle_threshold, split_and_merge, incremental };

struct ExtractionParameters {
    Method method = Method::split_and_merge;  ///< why: tests/bench/lines_bench.cpp, docs/papers/lines.md

    // The noise model, see noise_model.h.
    double sigma_range_m = 0;      ///< along the beam; 0: what the scan states
    double sigma_bearing_rad = 0;  ///< of the beams' directions
    double sigma_wall_m = 0.005;   ///< unevenness of walls, normal to them

    // Where a block of beams ends.
    double max_gap_m = 0.3;
    double max_incidence_rad = 80 * M_PI / 180;
    double angle_threshold_rad = 20 * M_PI / 180;

    // What is a line.
    int min_beams = 6;
    double min_length_m = 0.4;
    double max_bow = 0.01;  ///< sagitta over length
    double max_sigma_alpha_rad = 3 * M_PI / 180;

    // Which lines are one.
    double max_merge_gap_m = 2;
};

}  // namespace loopline::lines
