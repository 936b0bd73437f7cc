/// The covariance of a line against Monte Carlo: what the extractor claims for one scan must be what its
/// lines scatter by over many scans of the same wall.
#include <gtest/gtest.h>

#include <random>

#include "lines/line_extractor.h"
#include "property/lines_world.h"

using namespace loopline;
using namespace loopline::lines;
using lines_world::Sensor;
using lines_world::Sweep;
using lines_world::World;

namespace {

struct View {
    const char* name;
    double distance_m, from_m, to_m;  ///< the wall, seen from the sensor: x = distance, y from .. to
    double turn_rad;                  ///< of the sensor
    std::size_t beams;
    double sigma_range_m, sigma_bearing_rad, sigma_wall_m;
};

class LineCovariance : public testing::TestWithParam<View> {};

Sweep noisy_sweep(const View& view, const World& world, const Sensor& sensor, std::mt19937_64& random) {
    Sweep sweep = lines_world::sweep(world, sensor);
    std::normal_distribution<double> unit(0, 1);
    const auto truth = lines_world::true_line(world.walls[0], sensor.T_world_sensor);
    for (std::size_t i = 0; i < sweep.scan.size(); ++i) {
        if (sweep.wall[i] != 0) continue;
        // A beam that points off by b and meets a wall that stands out by u.
        const double incidence =
            sweep.scan.angle_rad(i) + view.sigma_bearing_rad * unit(random) - truth.alpha_rad;
        const double range = (truth.rho_m + view.sigma_wall_m * unit(random)) / std::cos(incidence);
        sweep.scan.ranges_m[i] = static_cast<float>(range + view.sigma_range_m * unit(random));
    }
    sweep.scan.sigma_range_m = view.sigma_range_m;
    return sweep;
}

TEST_P(LineCovariance, is_what_lines_scatter_by) {
    const View view = GetParam();
    World world;
    world.walls.push_back({{view.distance_m, view.from_m}, {view.distance_m, view.to_m}});
    Sensor sensor;
    sensor.beams = view.beams;
    sensor.T_world_sensor.phi_rad = view.turn_rad;
    const auto truth = lines_world::true_line(world.walls[0], sensor.T_world_sensor);

    for (const Method method : {Method::angle_threshold, Method::split_and_merge, Method::incremental}) {
        ExtractionParameters parameters;
        parameters.method = method;
        parameters.sigma_wall_m = view.sigma_wall_m;
        parameters.sigma_bearing_rad = view.sigma_bearing_rad;
        const auto extractor = make_line_extractor(parameters);
        std::mt19937_64 random(20);
        LineSegments segments;
        Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero(), claimed = Eigen::Matrix2d::Zero();
        Eigen::Vector2d mean = Eigen::Vector2d::Zero();
        const int scans = 8000;
        int found = 0;
        for (int k = 0; k < scans; ++k) {
            extractor->extract(noisy_sweep(view, world, sensor, random).scan, segments);
            if (segments.size() != 1) continue;
            ++found;
            const Eigen::Vector2d error(segments[0].rho_m - truth.rho_m,
                                        wrap_to_pi(segments[0].alpha_rad - truth.alpha_rad));
            mean += error;
            scatter += error * error.transpose();
            claimed += segments[0].covariance;
        }
        SCOPED_TRACE(testing::Message()
                     << view.name << ", method " << static_cast<int>(method) << ", found " << found);
        ASSERT_GT(found, 0.97 * scans);
        mean /= found;
        scatter /= found;
        claimed /= found;
        EXPECT_LT(std::abs(mean(0)), 0.15 * std::sqrt(scatter(0, 0))) << "bias of rho";
        EXPECT_LT(std::abs(mean(1)), 0.15 * std::sqrt(scatter(1, 1))) << "bias of alpha";
        EXPECT_NEAR(claimed(0, 0) / scatter(0, 0), 1, 0.1) << "variance of rho";
        EXPECT_NEAR(claimed(1, 1) / scatter(1, 1), 1, 0.1) << "variance of alpha";
        const auto correlation = [](const Eigen::Matrix2d& c) {
            return c(0, 1) / std::sqrt(c(0, 0) * c(1, 1));
        };
        EXPECT_NEAR(correlation(claimed), correlation(scatter), 0.1) << "correlation";
    }
}

INSTANTIATE_TEST_SUITE_P(Views, LineCovariance,
                         testing::Values(View{"near, frontal, many beams", 1.5, -2, 2, 0, 361, 0.01, 0, 0},
                                         View{"near, frontal, few beams", 1.5, -0.6, 0.6, 0, 91, 0.01, 0, 0},
                                         View{"far, frontal", 12, -4, 4, 0.3, 361, 0.01, 0, 0},
                                         View{"far, frontal, few beams", 12, -2, 2, 0, 91, 0.01, 0, 0},
                                         View{"near, oblique, many beams", 1, 2, 6, 0.5, 721, 0.01, 0, 0},
                                         View{"oblique, few beams", 2, 2, 8, -0.4, 181, 0.01, 0, 0},
                                         View{"along a corridor", 1, 0, 12, 0.9, 361, 0.01, 0, 0},
                                         View{"coarse sensor", 4, -3, 3, 0.2, 361, 0.05, 0, 0},
                                         View{"uneven wall", 3, 0, 4, 0, 361, 0.01, 0, 0.01},
                                         View{"beams that point off", 3, 1, 5, 0, 361, 0.005, 0.003, 0},
                                         View{"all three", 4, -1, 6, 0, 541, 0.01, 0.002, 0.005}),
                         [](const auto& view) {
                             std::string name = view.param.name;
                             for (char& c : name)
                                 if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
                             return name;
                         });

}  // namespace
