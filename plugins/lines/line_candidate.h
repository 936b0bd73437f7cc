/// A line on its way from a straight run of points to publication.
#pragma once

#include <algorithm>
#include <cmath>

#include "lines/line_fit.h"
#include "lines/scan_points.h"

namespace loopline::lines {

struct LineCandidate {
    Interval part;         ///< the piece that it comes from
    std::size_t line = 0;  ///< index of the candidate that has the part's points: itself until it is merged
    Interval run;          ///< from its first point to its last; others may lie between
    Moments moments;       ///< of its points
    LikelyFit fit;
    bool rejected = false;
    std::size_t first = 0;  ///< outermost points of the fit, in the order of bearing
    std::size_t last = 0;
    bool over_the_seam =
        false;  ///< in a full-circle scan: begins before its end and ends after its beginning

    void take(const LikelyFit& likely_fit) {
        fit = likely_fit;
        rejected = !fit.valid;
        if (over_the_seam) return;
        first = fit.first;
        last = fit.last;
    }
    double length_m(const ScanPoints& points) const {
        return fit.line.along_m(points[last].x_m, points[last].y_m) -
               fit.line.along_m(points[first].x_m, points[first].y_m);
    }
};

/// Angle from a's normal to b's, in [-pi/2, pi/2] for lines seen from the same side.
inline double turn_rad(const NormalForm& a, const NormalForm& b) {
    return std::asin(std::clamp(a.nx * b.ny - a.ny * b.nx, -1.0, 1.0));
}

}  // namespace loopline::lines
