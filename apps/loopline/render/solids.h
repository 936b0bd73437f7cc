/// Solid bodies of a spatial scene as triangles: OpenGL lines of MRPT are one pixel wide whatever is asked
/// for.
#pragma once

#include <mrpt/opengl/CSetOfTriangles.h>

#include <Eigen/Core>
#include <vector>

#include "api/pose2.h"
#include "render/palette.h"

namespace loopline {

/// A tube of round section along the vertices (map frame), which must be distinct.
void add_tube(mrpt::opengl::CSetOfTriangles& mesh, const std::vector<Eigen::Vector3d>& vertices_m,
              double radius_m, Colour colour);

/// An upright slab over the ground segment from `start_m` to `end_m`, `floor_m` its lower height.
void add_wall(mrpt::opengl::CSetOfTriangles& mesh, const Eigen::Vector2d& start_m,
              const Eigen::Vector2d& end_m, double floor_m, double height_m, double thickness_m, Colour sides,
              Colour top);

/// A pin: a thin post with a ball on it, `base_m` its foot.
void add_pin(mrpt::opengl::CSetOfTriangles& mesh, const Eigen::Vector3d& base_m, double height_m,
             double ball_radius_m, Colour colour);

/// A small cart at a planar pose, half a metre long, with an arrow on it that points forward.
void add_cart(mrpt::opengl::CSetOfTriangles& mesh, const Pose2& T_map_base, double floor_m, Colour body,
              Colour arrow);

}  // namespace loopline
