/// All points of a cloud's file.
#pragma once

#include "render/point_files.h"

namespace loopline::test {

inline std::vector<Eigen::Vector3f> points_in(const std::filesystem::path& file) {
    return finite_points(*points_of_file(file));
}

}  // namespace loopline::test
