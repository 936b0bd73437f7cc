/// The content as MRPT's 3D scene, for off-screen pictures and for .3Dscene files.
#pragma once

#include <mrpt/opengl/COpenGLScene.h>

#include <optional>
#include <vector>

#include "render/content_bounds.h"
#include "render/scene_content.h"

namespace loopline {

/// Sizes of things in a scene, in metres: what reads well depends on how far away one is.
struct SceneSizes {
    double wall_height_m = 2;
    double wall_thickness_m = 0.1;
    double path_radius_m = 0.08;
    double pin_height_m = 2;
    double grid_step_m = 5;
    float point_px = 3;
    std::size_t most_points = 1'000'000;
    std::optional<Bounds> ground;  ///< where the grid lies, if not under the whole content
    bool end_pin = true;           ///< where the path ends; off where the vehicle itself stands there
};

/// Sizes for a look at the whole content from outside.
SceneSizes sizes_for_overview(const SceneContent& content);

/// Ground grid, walls, points, paths, pins at start and end; no camera.
mrpt::opengl::COpenGLScene::Ptr make_spatial_scene(const SceneContent& content, const SceneSizes& sizes);

/// `points_m` if there are no more than `most`; else one point per cube of a lattice, coarse enough for that.
/// Keeps the order.
std::vector<Eigen::Vector3f> thinned_points(const std::vector<Eigen::Vector3f>& points_m, std::size_t most);

}  // namespace loopline
