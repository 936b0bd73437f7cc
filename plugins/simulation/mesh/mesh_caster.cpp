#include "simulation/mesh/mesh_caster.h"

#include <dlfcn.h>

#include <Eigen/Geometry>
#include <filesystem>
#include <stdexcept>

#include "simulation/mesh/embree_entry.h"

namespace loopline::simulation {
namespace {

Eigen::Vector3d corner_m(const TriangleMesh& mesh, std::size_t triangle, int corner) {
    return mesh.vertices_m[mesh.triangles[triangle][static_cast<std::size_t>(corner)]].cast<double>();
}

class PlainCaster : public MeshCaster {
 public:
    explicit PlainCaster(const TriangleMesh& mesh) : mesh_(mesh) {}

    void cast(const std::vector<MeshRay>& rays, double max_range_m,
              std::vector<MeshHit>& hits) const override {
        hits.assign(rays.size(), {});
        for (std::size_t i = 0; i < rays.size(); ++i)
            for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
                if (!meets_triangle(mesh_, t, rays[i])) continue;
                const MeshHit hit = hit_on_triangle(mesh_, t, rays[i]);
                if (hit.range_m < hits[i].range_m && hit.range_m <= max_range_m) hits[i] = hit;
            }
    }

 private:
    const TriangleMesh& mesh_;
};

/// The folder of this library, or program.
std::filesystem::path own_folder() {
    Dl_info info{};
    if (dladdr(reinterpret_cast<void*>(&own_folder), &info) == 0 || info.dli_fname == nullptr) return {};
    return std::filesystem::absolute(info.dli_fname).parent_path();
}

}  // namespace

MeshHit hit_on_triangle(const TriangleMesh& mesh, std::size_t triangle, const MeshRay& ray) {
    const Eigen::Vector3d a_m = corner_m(mesh, triangle, 0);
    const Eigen::Vector3d normal =
        (corner_m(mesh, triangle, 1) - a_m).cross(corner_m(mesh, triangle, 2) - a_m).normalized();
    const double along = normal.dot(ray.direction);
    return {normal.dot(a_m - ray.origin_m) / along, std::abs(along), mesh.materials[triangle]};
}

bool meets_triangle(const TriangleMesh& mesh, std::size_t triangle, const MeshRay& ray) {
    const Eigen::Vector3d a_m = corner_m(mesh, triangle, 0), ab_m = corner_m(mesh, triangle, 1) - a_m,
                          ac_m = corner_m(mesh, triangle, 2) - a_m;
    const Eigen::Vector3d across = ray.direction.cross(ac_m);
    const double determinant = ab_m.dot(across);
    if (determinant == 0) return false;
    const Eigen::Vector3d from_a_m = ray.origin_m - a_m;
    const double u = from_a_m.dot(across) / determinant;
    if (u < 0 || u > 1) return false;
    const Eigen::Vector3d side = from_a_m.cross(ab_m);
    const double v = ray.direction.dot(side) / determinant;
    return v >= 0 && u + v <= 1 && ac_m.dot(side) / determinant > 0;
}

std::unique_ptr<MeshCaster> make_plain_caster(const TriangleMesh& mesh) {
    return std::make_unique<PlainCaster>(mesh);
}

std::unique_ptr<MeshCaster> make_mesh_caster(const TriangleMesh& mesh) {
    const auto file = own_folder() / "ray_casting" / "libloopline_embree.so";
    // Never closed: a caster's code must outlive it.
    void* const library = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
    void* const entry = library != nullptr ? dlsym(library, embree_entry_name) : nullptr;
    if (entry == nullptr) {
        const char* const reason = dlerror();
        if (!std::filesystem::exists(file))
            throw std::runtime_error("a spinning lidar needs Embree; install libembree-dev and build again");
        throw std::runtime_error(
            std::string("a spinning lidar needs Embree (libembree3-3), which can't be loaded: ") +
            (reason != nullptr ? reason : file.string() + " is damaged"));
    }
    return std::unique_ptr<MeshCaster>(reinterpret_cast<EmbreeEntry>(entry)(&mesh));
}

}  // namespace loopline::simulation
