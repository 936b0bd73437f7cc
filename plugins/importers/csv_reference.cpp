#include "importers/csv_reference.h"

#include "api/attitude.h"

namespace loopline::csv {

Reference::Reference(ColumnMap& map, const Section& section, const std::string& path,
                     std::vector<Problem>& problems)
    : section_(section),
      rows_(map, section, path, false, problems),
      T_sensor_base_(section.T_base_sensor().inverse()),
      ecef_{rows_.slot("ecef_x"), rows_.slot("ecef_y"), rows_.slot("ecef_z")},
      latitude_(rows_.slot("latitude")),
      longitude_(rows_.slot("longitude")),
      height_(rows_.slot("height")),
      place_{rows_.slot("x"), rows_.slot("y"), rows_.slot("z")},
      yaw_(rows_.slot("yaw")),
      heading_(rows_.slot("heading")),
      pitch_(rows_.slot("pitch")),
      roll_(rows_.slot("roll")),
      q_{rows_.slot("qw"), rows_.slot("qx"), rows_.slot("qy"), rows_.slot("qz")} {
    if (section.has_origin())
        frame_ = EarthFrame{section.origin_latitude_deg, section.origin_longitude_deg,
                            section.origin_height_m, section.origin_heading_deg};
}

Eigen::Quaterniond Reference::rotation() const {
    if (q_[0] != Rows::none) {
        const auto q =
            Eigen::Quaterniond(rows_.value(q_[0]), rows_.value(q_[1]), rows_.value(q_[2]), rows_.value(q_[3]))
                .normalized();
        return section_.quaternion_is_inverse ? q.conjugate() : q;
    }
    const double yaw_rad = yaw_ != Rows::none ? rows_.value(yaw_) : M_PI / 2 - rows_.value(heading_);
    return attitude(yaw_rad, rows_.value_or(pitch_, 0), rows_.value_or(roll_, 0));
}

Pose3 Reference::in_local_frame(const Eigen::Vector3d& p_ecef_m, const Eigen::Matrix3d& R_ecef_sensor) {
    if (!frame_) {
        const gnss::Geodetic origin = gnss::geodetic_from_ecef(p_ecef_m);
        frame_ = EarthFrame{origin.latitude_deg, origin.longitude_deg, origin.height_m, 0};
        p_ecef_origin_m_ = p_ecef_m;
        R_ecef_ref_ = gnss::R_ecef_enu(origin.latitude_deg, origin.longitude_deg);
    }
    const Eigen::Matrix3d R_ref_sensor = R_ecef_ref_.transpose() * R_ecef_sensor;
    return {R_ecef_ref_.transpose() * (p_ecef_m - p_ecef_origin_m_), Eigen::Quaterniond(R_ref_sensor)};
}

Pose3 Reference::T_ref_sensor() {
    if (ecef_[0] != Rows::none)
        return in_local_frame({rows_.value(ecef_[0]), rows_.value(ecef_[1]), rows_.value(ecef_[2])},
                              rotation().toRotationMatrix());
    if (latitude_ != Rows::none) {
        const gnss::Geodetic place{rows_.value(latitude_) / gnss::rad_per_deg,
                                   rows_.value(longitude_) / gnss::rad_per_deg, rows_.value(height_)};
        return in_local_frame(gnss::p_ecef_m(place),
                              gnss::R_ecef_enu(place.latitude_deg, place.longitude_deg) * rotation());
    }
    return {{rows_.value(place_[0]), rows_.value(place_[1]), rows_.value_or(place_[2], 0)}, rotation()};
}

bool Reference::next(TruePose& pose) {
    if (!rows_.next()) return false;
    pose.time_ns = rows_.time_ns();
    pose.T_ref_base = T_ref_sensor() * T_sensor_base_;
    return true;
}

}  // namespace loopline::csv
