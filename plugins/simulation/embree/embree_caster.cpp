/// Rays by Embree (Wald et al. 2014, "Embree: a kernel framework for efficient CPU ray tracing"), which finds
/// the triangle; the distance to it is computed here.
#include <embree3/rtcore.h>

#include <stdexcept>
#include <string>

#include "simulation/mesh/embree_entry.h"
#include "simulation/mesh/mesh_caster.h"

namespace loopline::simulation {
namespace {

/// One instruction set and one thread, so that every processor builds the same tree and decides alike.
constexpr const char* device_settings = "isa=sse4.2,threads=1";

class EmbreeCaster : public MeshCaster {
 public:
    explicit EmbreeCaster(const TriangleMesh& mesh) : mesh_(mesh), device_(rtcNewDevice(device_settings)) {
        if (device_ == nullptr) throw std::runtime_error("Embree does not work on this processor");
        scene_ = rtcNewScene(device_);
        rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST);  // nothing slips through between two triangles
        RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
        // Embree reads 16 bytes at the last vertex, so it gets a copy that it pads by itself.
        auto* const vertices = static_cast<float*>(
            rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float),
                                    mesh.vertices_m.size()));
        for (std::size_t i = 0; i < mesh.vertices_m.size(); ++i)
            for (int axis = 0; axis < 3; ++axis)
                vertices[3 * i + static_cast<std::size_t>(axis)] = mesh.vertices_m[i][axis];
        rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                   mesh.triangles.data(), 0, sizeof(mesh.triangles[0]),
                                   mesh.triangles.size());
        rtcCommitGeometry(geometry);
        rtcAttachGeometry(scene_, geometry);
        rtcReleaseGeometry(geometry);
        rtcCommitScene(scene_);
        if (rtcGetDeviceError(device_) != RTC_ERROR_NONE)
            throw std::runtime_error("Embree can't hold this world");
    }
    ~EmbreeCaster() override {
        rtcReleaseScene(scene_);
        rtcReleaseDevice(device_);
    }
    EmbreeCaster(const EmbreeCaster&) = delete;
    EmbreeCaster& operator=(const EmbreeCaster&) = delete;

    void cast(const std::vector<MeshRay>& rays, double max_range_m,
              std::vector<MeshHit>& hits) const override {
        hits.assign(rays.size(), {});
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
        stream_.resize(rays.size());
        for (std::size_t i = 0; i < rays.size(); ++i) stream_[i] = asked(rays[i], max_range_m);
        rtcIntersect1M(scene_, &context, stream_.data(), static_cast<unsigned>(rays.size()),
                       sizeof(RTCRayHit));
        for (std::size_t i = 0; i < rays.size(); ++i)
            if (stream_[i].hit.geomID != RTC_INVALID_GEOMETRY_ID) hits[i] = found(rays[i], stream_[i]);
    }

 private:
    static RTCRayHit asked(const MeshRay& ray, double max_range_m) {
        RTCRayHit question{};
        question.ray.org_x = static_cast<float>(ray.origin_m.x());
        question.ray.org_y = static_cast<float>(ray.origin_m.y());
        question.ray.org_z = static_cast<float>(ray.origin_m.z());
        question.ray.dir_x = static_cast<float>(ray.direction.x());
        question.ray.dir_y = static_cast<float>(ray.direction.y());
        question.ray.dir_z = static_cast<float>(ray.direction.z());
        question.ray.tfar = static_cast<float>(max_range_m);
        question.ray.mask = 0xffffffffu;
        question.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        question.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
        return question;
    }
    MeshHit found(const MeshRay& ray, const RTCRayHit& answer) const {
        MeshHit hit = hit_on_triangle(mesh_, answer.hit.primID, ray);
        // Along a triangle that is seen edge on, only Embree's own number makes sense.
        const double rough_m = answer.ray.tfar;
        if (!(std::abs(hit.range_m - rough_m) < 1e-3 * (1 + rough_m))) hit.range_m = rough_m;
        return hit;
    }

    const TriangleMesh& mesh_;
    RTCDevice device_;
    RTCScene scene_ = nullptr;
    mutable std::vector<RTCRayHit> stream_;  ///< memory from call to call
};

}  // namespace
}  // namespace loopline::simulation

extern "C" loopline::simulation::MeshCaster* loopline_make_embree_caster(
    const loopline::simulation::TriangleMesh* mesh) {
    return new loopline::simulation::EmbreeCaster(*mesh);
}
