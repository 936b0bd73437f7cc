/// Where a map lies on the Earth.
#pragma once

#include <Eigen/Geometry>
#include <string>

#include "api/earth_frame.h"
#include "api/pose3.h"
#include "gnss/local_frame.h"

namespace loopline::gnss {

/// The map's origin, and how its axes lie: z up, x turned from east. A map that lies as ENU does has the
/// heading 0.
class GeoReference {
 public:
    GeoReference() : GeoReference(Geodetic{}, 0) {}
    /// `heading_deg`: of the map's x axis, counter-clockwise from east.
    GeoReference(const Geodetic& origin, double heading_deg);
    explicit GeoReference(const EarthFrame& frame)
        : GeoReference(Geodetic{frame.latitude_deg, frame.longitude_deg, frame.height_m}, frame.heading_deg) {
    }

    const Geodetic& origin() const { return frame_.origin(); }
    double heading_deg() const { return heading_deg_; }
    /// Turns map coordinates to ENU about the origin.
    const Eigen::Matrix3d& R_enu_map() const { return R_enu_map_; }

    Eigen::Vector3d p_map_m(const Geodetic& place) const {
        return R_enu_map_.transpose() * frame_.p_enu_m(place);
    }
    Geodetic geodetic(const Eigen::Vector3d& p_map_m) const { return frame_.geodetic(R_enu_map_ * p_map_m); }

 private:
    LocalFrame frame_;
    double heading_deg_;
    Eigen::Matrix3d R_enu_map_;
};

/// From the coordinates of one such frame to those of another: both are straight, so it is a rigid motion.
Pose3 T_between(const GeoReference& to, const GeoReference& from);

/// The text of a file beside a map: `key = value` lines that read back to the same bits; where UTM is
/// defined, the origin on its grid too, which a reader need not look at.
std::string georeference_text(const GeoReference& reference);
/// Of such a text; comments and blank lines are skipped. Throws std::runtime_error with one sentence that
/// begins with `name` and tells what is wrong.
GeoReference georeference_from_text(const std::string& text, const std::string& name);

/// Throws std::runtime_error, with one sentence, if the file can't be written or read.
void write_georeference(const std::string& file, const GeoReference& reference);
GeoReference read_georeference(const std::string& file);

}  // namespace loopline::gnss
