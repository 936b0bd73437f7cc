/// A spatial pose as plain numbers, for lists that may lie on disk (api/set_aside.h).
#pragma once

#include "api/pose3.h"

namespace loopline {

/// (x y z qx qy qz qw), which come back as they were.
struct Pose3Record {
    double numbers[7] = {0, 0, 0, 0, 0, 0, 1};

    Pose3Record() = default;
    explicit Pose3Record(const Pose3& pose) {
        Eigen::Map<Eigen::Vector3d>{numbers} = pose.translation_m;
        Eigen::Map<Eigen::Vector4d>{numbers + 3} = pose.rotation.coeffs();
    }
    Pose3 pose() const {
        return {Eigen::Map<const Eigen::Vector3d>(numbers),
                Eigen::Quaterniond(Eigen::Map<const Eigen::Vector4d>(numbers + 3))};
    }
};

}  // namespace loopline
