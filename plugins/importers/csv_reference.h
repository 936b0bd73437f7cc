/// A table of where the vehicle really was, as poses in a local frame that may lie somewhere on the Earth.
#pragma once

#include "api/earth_frame.h"
#include "gnss/geo_reference.h"
#include "importers/csv_rows.h"

namespace loopline::csv {

/// Kind "reference". Places on the Earth become those of a local frame (x east, y north, z up) about the
/// first one.
class Reference {
 public:
    Reference(ColumnMap& map, const Section& section, const std::string& path,
              std::vector<Problem>& problems);

    struct TruePose {
        StampNs time_ns = 0;  ///< of the table
        Pose3 T_ref_base;
    };
    /// The next pose; false at the end.
    bool next(TruePose& pose);
    /// Of the poses so far: nothing if their place on the Earth is not known.
    const std::optional<EarthFrame>& frame() const { return frame_; }
    std::vector<std::string> complaints() const { return rows_.complaints(); }

 private:
    /// Of what the reference is of, in the frame in which the table has it; axes of ENU for places on the
    /// Earth.
    Eigen::Quaterniond rotation() const;
    Pose3 T_ref_sensor();
    Pose3 in_local_frame(const Eigen::Vector3d& p_ecef_m, const Eigen::Matrix3d& R_ecef_sensor);

    const Section& section_;
    Rows rows_;
    Pose3 T_sensor_base_;
    int ecef_[3], latitude_, longitude_, height_, place_[3], yaw_, heading_, pitch_, roll_, q_[4];
    std::optional<EarthFrame> frame_;
    Eigen::Vector3d p_ecef_origin_m_ = Eigen::Vector3d::Zero();
    Eigen::Matrix3d R_ecef_ref_ = Eigen::Matrix3d::Identity();
};

}  // namespace loopline::csv
