/// The spinning lidar and what it sees: rays against closed formulas, motion within a sweep, light that does
/// not come back.
#include <gtest/gtest.h>

#include <cmath>

#include "lidar/range_image.h"
#include "simulation/mesh/solids.h"
#include "simulation/spinning_lidar.h"

using namespace loopline;
using namespace loopline::simulation;

namespace {

constexpr double hall_length_m = 40, hall_width_m = 24, hall_height_m = 6;

/// A closed hall about the origin, which is on its floor.
TriangleMesh hall(Material material) {
    TriangleMesh mesh;
    add_block(mesh, {Pose2{}, hall_length_m, hall_width_m}, 0, hall_height_m, material);
    const double l = hall_length_m / 2, w = hall_width_m / 2;
    mesh.add_quad({-l, -w, 0}, {l, -w, 0}, {l, w, 0}, {-l, w, 0}, material);
    return mesh;
}

double way_out_of_hall_m(const MeshRay& ray) {
    const Eigen::Vector3d low_m(-hall_length_m / 2, -hall_width_m / 2, 0),
        high_m(hall_length_m / 2, hall_width_m / 2, hall_height_m);
    double least_m = 1e9;
    for (int axis = 0; axis < 3; ++axis) {
        const double d = ray.direction[axis], to_m = (d > 0 ? high_m : low_m)[axis] - ray.origin_m[axis];
        if (d != 0) least_m = std::min(least_m, to_m / d);
    }
    return least_m;
}

double off_the_hall_m(const Eigen::Vector3d& p) {
    return std::min({std::abs(std::abs(p.x()) - hall_length_m / 2),
                     std::abs(std::abs(p.y()) - hall_width_m / 2), std::abs(p.z()),
                     std::abs(p.z() - hall_height_m)});
}

MeshRay random_ray(RandomStream& random) {
    return {{random.uniform(-18, 18), random.uniform(-10, 10), random.uniform(0.5, 5)},
            Eigen::Vector3d(random.normal(1), random.normal(1), random.normal(0.3)).normalized()};
}

/// Fast, round a bend, and swaying.
Pose3 in_motion(StampNs time_ns) {
    const double t = seconds_between(0, time_ns);
    return {{-5 + 12 * t, 2 * std::sin(2 * t), 1.7 + 0.1 * std::sin(9 * t)},
            Eigen::Quaterniond(Eigen::AngleAxisd(1.2 * t, Eigen::Vector3d::UnitZ()) *
                               Eigen::AngleAxisd(0.05 * std::sin(8 * t), Eigen::Vector3d::UnitY()) *
                               Eigen::AngleAxisd(0.08 * std::cos(7 * t), Eigen::Vector3d::UnitX()))};
}

SpinningLidarSettings without_errors() {
    SpinningLidarSettings settings;
    settings.beams = 32;
    settings.columns = 360;
    settings.sigma_range_m = settings.dropouts = 0;
    settings.least_reflectance = 1e-6;
    return settings;
}

lidar::SpinningScan points_of(const SpinningLidar& model, const std::vector<std::uint16_t>& ranges) {
    lidar::SpinningScan scan;
    lidar::RangeImageReader reader;
    reader.read(model.geometry(), ranges.data(), static_cast<std::size_t>(model.geometry().columns), scan);
    return scan;
}

StampNs time_of(const lidar::SpinningPoint& p) {
    return static_cast<StampNs>(std::llround(1e9 * p.time_s));
}

double part_returned(SpinningLidar& model, const MeshCaster& caster, const Pose3& T_map_lidar) {
    const auto& ranges = model.scan(
        0, [&](StampNs) { return T_map_lidar; }, caster);
    return 1 - static_cast<double>(std::count(ranges.begin(), ranges.end(), 0)) /
                   static_cast<double>(ranges.size());
}

}  // namespace

TEST(MeshCaster, embree_meets_the_walls_of_a_hall) {
    // Far from the origin, where single precision is coarse.
    TriangleMesh mesh = hall(Material::plaster);
    const Eigen::Vector3d away_m(512, -256, 32);
    for (auto& vertex : mesh.vertices_m) vertex += away_m.cast<float>();
    const auto caster = make_mesh_caster(mesh);
    RandomStream random(1, "rays");
    std::vector<MeshRay> rays;
    for (int i = 0; i < 4000; ++i) rays.push_back(random_ray(random));
    std::vector<MeshRay> moved = rays;
    for (MeshRay& ray : moved) ray.origin_m += away_m;
    std::vector<MeshHit> hits;
    caster->cast(moved, 100, hits);
    for (std::size_t i = 0; i < rays.size(); ++i)
        ASSERT_NEAR(hits[i].range_m, way_out_of_hall_m(rays[i]), 1e-5) << i;
}

TEST(MeshCaster, embree_meets_what_brute_force_meets) {
    RandomStream random(2, "triangles");
    TriangleMesh mesh;
    const auto corner = [&] {
        return Eigen::Vector3d(random.uniform(-20, 20), random.uniform(-12, 12), random.uniform(0, 6));
    };
    for (int i = 0; i < 300; ++i) {
        const Eigen::Vector3d a_m = corner();
        const auto near_it = [&]() -> Eigen::Vector3d {
            return a_m + Eigen::Vector3d(random.normal(2), random.normal(2), random.normal(1));
        };
        mesh.add_triangle(a_m, near_it(), near_it(), i % 2 == 0 ? Material::brick : Material::glass);
    }
    std::vector<MeshRay> rays;
    for (int i = 0; i < 3000; ++i) rays.push_back(random_ray(random));
    std::vector<MeshHit> quick, plain;
    make_mesh_caster(mesh)->cast(rays, 30, quick);
    make_plain_caster(mesh)->cast(rays, 30, plain);
    std::size_t met = 0, different = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        met += std::isfinite(plain[i].range_m);
        // Only on the very edge of a triangle may they disagree.
        different += quick[i].range_m != plain[i].range_m || quick[i].material != plain[i].material;
    }
    EXPECT_GT(met, 1000u);
    EXPECT_LE(different, 2u);
}

TEST(SpinningLidar, points_of_a_moving_lidar_lie_where_they_were_met) {
    const TriangleMesh mesh = hall(Material::plaster);
    const auto caster = make_plain_caster(mesh);
    SpinningLidar model(without_errors(), RandomStream(1, "lidar"));
    const StampNs start_ns = 300'000'000;
    const auto scan = points_of(model, model.scan(start_ns, in_motion, *caster));
    ASSERT_EQ(scan.points.size(), 32u * 360);
    double worst_m = 0, worst_without_motion_m = 0;
    for (const auto& p : scan.points) {
        const Eigen::Vector3d p_lidar(p.x_m, p.y_m, p.z_m);
        worst_m = std::max(worst_m, off_the_hall_m(in_motion(start_ns + time_of(p)) * p_lidar));
        worst_without_motion_m =
            std::max(worst_without_motion_m, off_the_hall_m(in_motion(start_ns) * p_lidar));
    }
    EXPECT_LT(worst_m, 0.0011) << "half a unit of ranges";
    EXPECT_GT(worst_without_motion_m, 0.5);
    EXPECT_NEAR(scan.end_s, 0.1, 0.001);
}

TEST(SpinningLidar, a_body_is_where_it_is_at_the_time_of_each_column) {
    const TriangleMesh mesh = hall(Material::plaster);
    const auto caster = make_plain_caster(mesh);
    std::vector<TriangleMesh> bodies(1);
    add_block(bodies[0], {Pose2{}, 4, 2}, 0, 2.5, Material::paint);
    const auto T_map_body = [](StampNs time_ns) {
        return Pose3(Pose2{4, -8 + 60 * seconds_between(0, time_ns), 0.3});
    };
    MovingWorld moving{&bodies, [&](StampNs time_ns) {
                           return std::vector<MovingBody>{{0, T_map_body(time_ns)}};
                       }};
    SpinningLidar model(without_errors(), RandomStream(1, "lidar"));
    const Pose3 T_map_lidar({-3, 0, 1.5}, Eigen::Quaterniond::Identity());
    const auto scan = points_of(model, model.scan(
                                           0, [&](StampNs) { return T_map_lidar; }, *caster, moving));
    std::size_t on_body = 0;
    for (const auto& p : scan.points) {
        const Eigen::Vector3d p_map = T_map_lidar * Eigen::Vector3d(p.x_m, p.y_m, p.z_m);
        if (off_the_hall_m(p_map) < 0.002) continue;
        ++on_body;
        const Eigen::Vector3d p_body = T_map_body(time_of(p)).inverse() * p_map;
        ASSERT_NEAR(std::min({std::abs(std::abs(p_body.x()) - 2), std::abs(std::abs(p_body.y()) - 1),
                              std::abs(p_body.z() - 2.5)}),
                    0, 0.002);
    }
    EXPECT_GT(on_body, 200u);
}

TEST(SpinningLidar, noise_and_losses_are_as_asked_for) {
    const TriangleMesh mesh = hall(Material::plaster);
    const auto caster = make_plain_caster(mesh);
    const Pose3 T_map_lidar({0, 0, 2}, Eigen::Quaterniond::Identity());
    const auto standing = [&](StampNs) { return T_map_lidar; };
    SpinningLidarSettings settings = without_errors();
    SpinningLidar exact(settings, RandomStream(1, "lidar"));
    const std::vector<std::uint16_t> ideal = exact.scan(0, standing, *caster);
    settings.sigma_range_m = 0.05;
    settings.dropouts = 0.1;
    SpinningLidar noisy(settings, RandomStream(1, "lidar"));
    const std::vector<std::uint16_t> real = noisy.scan(0, standing, *caster);
    double squares_m2 = 0, count = 0;
    for (std::size_t i = 0; i < real.size(); ++i) {
        if (real[i] == 0) continue;
        squares_m2 += std::pow(0.002 * (real[i] - ideal[i]), 2);
        ++count;
    }
    EXPECT_NEAR(count / static_cast<double>(real.size()), 0.9, 0.01);
    EXPECT_NEAR(std::sqrt(squares_m2 / count), 0.05, 0.002);
}

TEST(SpinningLidar, dark_surfaces_and_flat_incidence_return_less) {
    SpinningLidarSettings settings = without_errors();
    settings.least_reflectance = 0.5;
    settings.max_range_m = 60;
    const Pose3 middle({0, 0, 2}, Eigen::Quaterniond::Identity());
    double before = 1.1;
    for (const Material material : {Material::plaster, Material::asphalt, Material::glass}) {
        const TriangleMesh mesh = hall(material);
        SpinningLidar model(settings, RandomStream(1, "lidar"));
        const double part = part_returned(model, *make_plain_caster(mesh), middle);
        EXPECT_LT(part, before - 0.05);
        before = part;
    }
    EXPECT_GT(before, 0);
}
