/// Transverse Mercator projection of WGS84 by Krueger's series in the third flattening n (Kawase 2011, "A
/// general formula for calculating meridian arc length and its application to coordinate conversion in the
/// Gauss-Krueger projection"), to n^6 as in Karney 2011, "Transverse Mercator with an accuracy of a few
/// nanometers".
#pragma once

namespace loopline::gnss {

/// Of a point whose central meridian has longitude 0.
struct TransverseMercator {
    double east_m = 0;           ///< of the central meridian, before any scale or false easting
    double north_m = 0;          ///< of the equator
    double convergence_rad = 0;  ///< direction of grid north, clockwise from true north
    double scale = 1;            ///< length on the grid by length on the ellipsoid
};

/// Exact to nanometres up to 30 degrees beside the meridian; `longitude_deg` counts from that.
TransverseMercator project(double latitude_deg, double longitude_deg);

struct PlaceBesideMeridian {
    double latitude_deg = 0;
    double longitude_deg = 0;  ///< from the central meridian
};

/// The inverse of project().
PlaceBesideMeridian unproject(double east_m, double north_m);

}  // namespace loopline::gnss
