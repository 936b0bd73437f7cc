/// What stood for long and has left is no part of a cloud.
#include <gtest/gtest.h>

#include "cloud_map/cloud_map_module.h"
#include "support/cloud_map_scans.h"
#include "support/run_program.h"

using namespace loopline;
using namespace loopline::cloud_map;
using namespace loopline::cloud_map_scans;

namespace {

/// A room of 40 m, and in it a pillar and, as long as it stands there, a box.
lidar::SpinningScan room_from(double x_m, bool with_box, int k) {
    const auto range_to = [x_m](double cx_m, double cy_m, double half_m, double azimuth_rad) {
        double near_m = 0, far_m = 1e9;  // slabs
        const double from[] = {x_m, 0}, middle[] = {cx_m, cy_m},
                     along[] = {std::cos(azimuth_rad), std::sin(azimuth_rad)};
        for (int axis = 0; axis < 2; ++axis) {
            const double a = (middle[axis] - half_m - from[axis]) / along[axis],
                         b = (middle[axis] + half_m - from[axis]) / along[axis];
            near_m = std::max(near_m, std::min(a, b));
            far_m = std::min(far_m, std::max(a, b));
        }
        return near_m < far_m ? near_m > 0 ? near_m : far_m : 1e9;
    };
    auto scan = scan_of([&](double e, double a) {
        double level_m = range_to(0, 0, 20, a);
        level_m = std::min(level_m, range_to(2, -6, 0.15, a));
        if (with_box) level_m = std::min(level_m, range_to(3, 8, 1, a));
        return level_m / std::cos(e);
    });
    scan.stamp_ns = start_ns + 200'000'000LL * k;
    return scan;
}

}  // namespace

TEST(CloudMapRemoval, of_a_box_that_stood_for_a_minute_nothing_is_left_once_it_was_looked_through) {
    CloudMapSettings settings;
    for (const int seen : {6, 20, 60}) {
        CloudMapper mapper(settings, 1);
        int k = 0;
        for (; k < 5 * seen; ++k) mapper.add(room_from(0, true, k), {}, standing());
        // Seen through from the place of before, then on the way.
        for (int sweep = 0; sweep < 40; ++sweep) {
            const double x_m = std::max(0.0, 0.25 * (sweep - 10));
            mapper.add(room_from(x_m, false, k++), {},
                       standing({{x_m, 0, 0}, Eigen::Quaterniond::Identity()}));
        }
        mapper.finish();
        int of_box = 0, of_pillar = 0, of_wall = 0;
        for (const CloudPoint& point : mapper.cloud().points()) {
            const Eigen::Vector3d p = point.p_map_m();
            // What only the highest or lowest ring met, others can't look through.
            const bool between_rings = p.z() > -3.5 && p.z() < 1;
            of_box += between_rings && std::abs(p.x() - 3) < 1.1 && std::abs(p.y() - 8) < 1.1 ? 1 : 0;
            of_pillar += std::abs(p.x() - 2) < 0.2 && std::abs(p.y() + 6) < 0.2 ? 1 : 0;
            of_wall += p.y() > 19.8 && std::abs(p.x() - 3) < 2 ? 1 : 0;
        }
        EXPECT_EQ(of_box, 0) << seen;
        EXPECT_GT(of_pillar, 40) << seen;
        EXPECT_GT(of_wall, 100) << seen;  // behind the box, and seen only after it left
        EXPECT_GT(mapper.counts().moving, 200u) << seen;
    }
}
