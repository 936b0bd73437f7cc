/// The first triangle that a ray meets, among as many as a town has.
#pragma once

#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "simulation/mesh/triangle_mesh.h"

namespace loopline::simulation {

struct MeshRay {
    Eigen::Vector3d origin_m, direction;  ///< `direction` of length 1
};

struct MeshHit {
    double range_m = std::numeric_limits<double>::infinity();  ///< infinite: nothing there
    double cosine = 0;  ///< of the angle between ray and normal, positive
    Material material = Material::asphalt;
};

/// Where the ray meets the plane of a triangle; `hit` keeps its material. In double precision, so that a
/// distance depends on the triangle alone and not on how it was found.
MeshHit hit_on_triangle(const TriangleMesh& mesh, std::size_t triangle, const MeshRay& ray);
/// Whether that is inside of the triangle and ahead, by Moeller and Trumbore 1997.
bool meets_triangle(const TriangleMesh& mesh, std::size_t triangle, const MeshRay& ray);

class MeshCaster {
 public:
    virtual ~MeshCaster() = default;
    /// `hits` gets one for each ray. The same for the same rays, on any processor and for any number of
    /// threads.
    virtual void cast(const std::vector<MeshRay>& rays, double max_range_m,
                      std::vector<MeshHit>& hits) const = 0;
};

/// Embree's, from a library that is loaded now, for the first time: what drives no spinning lidar does
/// without it. Throws std::runtime_error, with one sentence, if it can't be had. `mesh` must outlive the
/// caster.
std::unique_ptr<MeshCaster> make_mesh_caster(const TriangleMesh& mesh);
/// Tries every triangle. For tests, and for meshes of a few triangles.
std::unique_ptr<MeshCaster> make_plain_caster(const TriangleMesh& mesh);

}  // namespace loopline::simulation
