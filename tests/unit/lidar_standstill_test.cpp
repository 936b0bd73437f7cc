/// Does a vehicle still stand where it stood? By the ranges of its lidar alone.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <random>

#include "lidar_mapping/standstill.h"

using namespace loopline;
using namespace loopline::lidar_mapping;

namespace {

/// Rings on the floor of a hall, from a lidar that may have moved. Somebody may stand 3 m beside it, in a
/// direction that reaches over 20 degrees.
lidar::SpinningScan rings_in_hall(double moved_m, double sigma_m, std::mt19937_64& random,
                                  double somebody_at_deg = 1000) {
    std::normal_distribution<double> normal;
    lidar::SpinningScan scan;
    for (int ring = 0; ring < 16; ++ring) {
        scan.ring_begin.push_back(static_cast<std::uint32_t>(scan.points.size()));
        const double elevation = (15 - 2 * ring) * M_PI / 180;
        for (int k = 0; k < 1800; ++k) {
            const double azimuth = (k + 0.3) * 0.2 * M_PI / 180 - M_PI;
            const Eigen::Vector3d beam(std::cos(elevation) * std::cos(azimuth),
                                       std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
            // Walls 12 m and 8 m off, the floor 1.5 m below.
            double range_m = 60;
            range_m = std::min(range_m, ((beam.x() > 0 ? 12 - moved_m : -12 - moved_m)) / beam.x());
            range_m = std::min(range_m, 8 / std::abs(beam.y()));
            if (beam.z() < 0) range_m = std::min(range_m, -1.5 / beam.z());
            if (std::abs(azimuth * 180 / M_PI - somebody_at_deg) < 10) range_m = std::min(range_m, 3.0);
            const Eigen::Vector3f p = ((range_m + sigma_m * normal(random)) * beam).cast<float>();
            scan.points.push_back({p.x(), p.y(), p.z(), 0});
        }
    }
    scan.ring_begin.push_back(static_cast<std::uint32_t>(scan.points.size()));
    return scan;
}

TEST(Standstill, lasts_until_the_vehicle_moves) {
    std::mt19937_64 random(10);
    Standstill standstill;
    for (int sweep = 0; sweep < 300; ++sweep)
        ASSERT_TRUE(standstill.lasts(rings_in_hall(0, 0.02, random))) << sweep;
    EXPECT_FALSE(standstill.lasts(rings_in_hall(0.02, 0.02, random)));
}

TEST(Standstill, lasts_while_somebody_goes_by) {
    std::mt19937_64 random(12);
    Standstill standstill;
    for (int sweep = 0; sweep < 5; ++sweep)
        ASSERT_TRUE(standstill.lasts(rings_in_hall(0, 0.02, random, -50))) << sweep;
    for (int sweep = 0; sweep < 100; ++sweep)
        ASSERT_TRUE(standstill.lasts(rings_in_hall(0, 0.02, random, -50 + sweep))) << sweep;
    EXPECT_FALSE(standstill.lasts(rings_in_hall(0.03, 0.02, random, 50)));
}

TEST(Standstill, is_over_from_the_second_sweep_of_a_vehicle_that_drives) {
    std::mt19937_64 random(11);
    Standstill standstill;
    EXPECT_TRUE(standstill.lasts(rings_in_hall(0, 0.02, random)));
    EXPECT_FALSE(standstill.lasts(rings_in_hall(0.5, 0.02, random)));
}

}  // namespace
