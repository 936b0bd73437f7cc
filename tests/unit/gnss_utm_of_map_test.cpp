/// The quick way to the UTM grid against the exact one.
#include <gtest/gtest.h>

#include <random>

#include "gnss/utm_of_map.h"

using namespace loopline;
using namespace loopline::gnss;

TEST(UtmOfMap, is_the_exact_grid_at_every_latitude_and_far_from_the_origin) {
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> unit(-1, 1);
    for (const auto& [latitude_deg, allowed_m] :
         {std::pair(0.0, 1e-6), {49.0, 1e-6}, {-75.0, 1e-6}, {83.9, 1e-5}, {-79.9, 1e-5}}) {
        const GeoReference reference({latitude_deg, 8.9 + unit(random), 300}, 180 * unit(random));
        UtmOfMap quick(reference, *to_utm(reference.origin()));
        for (const double reach_m : {30.0, 3000.0, 150e3})
            for (int i = 0; i < 300; ++i) {
                const Eigen::Vector3d p_m(reach_m * unit(random), reach_m * unit(random), 500 * unit(random));
                ASSERT_LT((quick.p_utm_m(p_m) - quick.exact_p_utm_m(p_m)).norm(), allowed_m)
                    << latitude_deg << " at " << p_m.transpose();
            }
    }
}

TEST(UtmOfMap, forgets_cells_where_there_are_many) {
    const GeoReference reference({49, 8.4, 100}, 10);
    UtmOfMap quick(reference, *to_utm(reference.origin()));
    for (int round = 0; round < 2; ++round)
        for (int i = 0; i < 5000; ++i) {
            const Eigen::Vector3d p_m(256.0 * (i % 100), 256.0 * (i / 100), 3);
            ASSERT_LT((quick.p_utm_m(p_m) - quick.exact_p_utm_m(p_m)).norm(), 1e-6);
        }
}
