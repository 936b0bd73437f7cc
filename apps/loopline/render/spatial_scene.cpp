/// One MRPT object per kind of content: few draw calls, and names one can switch off in SceneViewer3D.
#include "render/spatial_scene.h"

#include <mrpt/opengl/CGridPlaneXY.h>
#include <mrpt/opengl/CPointCloudColoured.h>
#include <mrpt/opengl/CSetOfTriangles.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "render/content_bounds.h"
#include "render/scale.h"
#include "render/solids.h"

namespace loopline {
namespace {

constexpr Colour wall_sides{205, 211, 219}, wall_top{86, 97, 110}, ground_line{198, 205, 213};

std::vector<Eigen::Vector3d> vertices_of(const std::vector<Pose3>& path, double spacing_m, double lift_m) {
    std::vector<Eigen::Vector3d> vertices;
    for (const auto& pose : path) {
        const Eigen::Vector3d p = pose.translation_m + lift_m * Eigen::Vector3d::UnitZ();
        if (p.allFinite() && (vertices.empty() || (p - vertices.back()).norm() >= spacing_m))
            vertices.push_back(p);
    }
    return vertices;
}

std::shared_ptr<mrpt::opengl::CSetOfTriangles> path_object(const std::vector<Pose3>& path,
                                                           const SceneSizes& sizes, double lift_m,
                                                           Colour colour, const std::string& name) {
    auto mesh = mrpt::opengl::CSetOfTriangles::Create();
    add_tube(*mesh, vertices_of(path, 2 * sizes.path_radius_m, lift_m), sizes.path_radius_m, colour);
    mesh->setName(name);
    return mesh;
}

std::shared_ptr<mrpt::opengl::CPointCloudColoured> points_object(const std::vector<Eigen::Vector3f>& points_m,
                                                                 const SceneSizes& sizes) {
    const Bounds bounds = bounds_of_points(points_m);
    const double low_m = bounds.low_m.z(), span_m = bounds.extent_m().z();
    const bool by_height = span_m > 0.5;
    auto cloud = mrpt::opengl::CPointCloudColoured::Create();
    for (const auto& p : thinned_points(points_m, sizes.most_points)) {
        const Colour colour = by_height ? palette::height((p.z() - low_m) / span_m) : palette::scan_point;
        cloud->push_back(p.x(), p.y(), p.z(), colour.red / 255.f, colour.green / 255.f, colour.blue / 255.f);
    }
    cloud->setPointSize(sizes.point_px);
    cloud->enableVariablePointSize(false);
    cloud->setName("scan points");
    return cloud;
}

std::shared_ptr<mrpt::opengl::CGridPlaneXY> ground_object(const Bounds& bounds, double step_m) {
    const auto down = [step_m](double v) {
        return static_cast<float>((std::floor(v / step_m) - 1) * step_m);
    };
    const auto up = [step_m](double v) { return static_cast<float>((std::ceil(v / step_m) + 1) * step_m); };
    const double below_m = bounds.low_m.z() - 0.002 * std::max(1.0, bounds.extent_m().norm());
    auto ground = mrpt::opengl::CGridPlaneXY::Create(down(bounds.low_m.x()), up(bounds.high_m.x()),
                                                     down(bounds.low_m.y()), up(bounds.high_m.y()),
                                                     static_cast<float>(below_m), static_cast<float>(step_m));
    ground->setColor_u8(mrpt::img::TColor(ground_line.red, ground_line.green, ground_line.blue));
    ground->setName("ground grid");
    return ground;
}

/// A set of cubes, by open addressing: a tenth of the time of std::unordered_set for a million of them.
class CubeSet {
 public:
    explicit CubeSet(std::size_t most) {
        std::size_t size = 1024;
        while (size < 3 * most) size *= 2;
        slots_.assign(size, empty);
    }
    /// False if it was there.
    bool insert(std::uint64_t cube) {
        const std::size_t mask = slots_.size() - 1;
        // Fibonacci hashing: the upper bits of the product depend on all of the cube's.
        std::size_t at = (cube * 0x9E3779B97F4A7C15u >> 24) & mask;
        for (; slots_[at] != empty; at = (at + 1) & mask)
            if (slots_[at] == cube) return false;
        slots_[at] = cube;
        return true;
    }

 private:
    static constexpr std::uint64_t empty = ~std::uint64_t{0};
    std::vector<std::uint64_t> slots_;
};

}  // namespace

std::vector<Eigen::Vector3f> thinned_points(const std::vector<Eigen::Vector3f>& points_m, std::size_t most) {
    std::vector<Eigen::Vector3f> all;
    for (const auto& p : points_m)
        if (p.allFinite()) all.push_back(p);
    if (all.size() <= most) return all;
    const Bounds bounds = bounds_of_points(all);
    std::vector<Eigen::Vector3f> kept;
    for (double cube_m = std::max(1e-3, bounds.extent_m().maxCoeff() / 1500);; cube_m *= 1.5) {
        kept.clear();
        CubeSet taken(most + 1);
        for (const auto& p : all) {
            // 21 bits an axis; far strays share a cube at the rim.
            std::uint64_t cube = 0;
            for (int axis = 0; axis < 3; ++axis) {
                const double cell = std::clamp((p[axis] - bounds.low_m[axis]) / cube_m, -1e6, 1e6);
                cube = cube << 21 | static_cast<std::uint64_t>(std::floor(cell) + (1 << 20));
            }
            if (taken.insert(cube)) kept.push_back(p);
            if (kept.size() > most) break;
        }
        if (kept.size() <= most) return kept;
    }
}

SceneSizes sizes_for_overview(const SceneContent& content) {
    Bounds bounds = bounds_of(content);
    const double diagonal_m = bounds.empty() ? 10 : std::max(2.0, bounds.extent_m().head<2>().norm());
    SceneSizes sizes;
    // Low enough to look over into corridors.
    sizes.wall_height_m = 0.02 * diagonal_m;
    sizes.wall_thickness_m = 0.0028 * diagonal_m;
    sizes.path_radius_m = 0.0024 * diagonal_m;
    sizes.pin_height_m = 0.035 * diagonal_m;
    sizes.grid_step_m = round_number_below(diagonal_m / 8);
    return sizes;
}

mrpt::opengl::COpenGLScene::Ptr make_spatial_scene(const SceneContent& content, const SceneSizes& sizes) {
    auto scene = mrpt::opengl::COpenGLScene::Create();
    Bounds bounds = bounds_of(content);
    bounds.add(bounds_of_path(content.odometry_path));
    if (bounds.empty()) bounds.add(Eigen::Vector3d::Zero());
    scene->insert(ground_object(sizes.ground.value_or(bounds), sizes.grid_step_m));

    if (!content.points_m.empty()) scene->insert(points_object(content.points_m, sizes));
    if (content.lines && !content.lines->empty()) {
        const Bounds path_bounds = bounds_of_path(content.estimated_path);
        const double floor_m = path_bounds.empty() ? 0 : path_bounds.low_m.z();
        auto walls = mrpt::opengl::CSetOfTriangles::Create();
        for (const auto& line : *content.lines)
            add_wall(*walls, line.start_m, line.end_m, floor_m, sizes.wall_height_m, sizes.wall_thickness_m,
                     wall_sides, wall_top);
        walls->setName("walls");
        scene->insert(walls);
    }
    // The estimate lies a little higher, so that it stays in sight where the two run together.
    const double r = sizes.path_radius_m;
    if (!content.odometry_path.empty())
        scene->insert(
            path_object(content.odometry_path, sizes, r, palette::dead_reckoning, "dead reckoning"));
    if (!content.estimated_path.empty()) {
        scene->insert(path_object(content.estimated_path, sizes, 2 * r, palette::estimate, "estimated path"));
        auto pins = mrpt::opengl::CSetOfTriangles::Create();
        const auto vertices = vertices_of(content.estimated_path, 0, 0);
        if (!vertices.empty()) {
            add_pin(*pins, vertices.front(), sizes.pin_height_m, 3.4 * r, palette::start);
            if (sizes.end_pin) add_pin(*pins, vertices.back(), sizes.pin_height_m, 3.4 * r, palette::end);
        }
        pins->setName("start and end");
        scene->insert(pins);
    }
    return scene;
}

}  // namespace loopline
