#include "simulation/spinning_lidar.h"

#include <algorithm>
#include <cmath>

#include "lidar/beam_table.h"

namespace loopline::simulation {
namespace {

constexpr double range_unit_m = 0.002;

}  // namespace

lidar::RangeImageGeometry geometry_of(const SpinningLidarSettings& settings) {
    lidar::RangeImageGeometry geometry;
    const double whole = static_cast<double>(settings.columns - 1) / settings.columns;
    geometry.columns = settings.columns;
    geometry.first_azimuth_rad = M_PI;
    geometry.azimuth_span_rad = -2 * M_PI * whole;
    geometry.sweep_s = whole / settings.rate_hz;
    geometry.range_unit_m = range_unit_m;
    if (const auto table = lidar::table_of_beams(settings.beams))
        geometry.elevations_deg = table->elevations_deg;
    return geometry;
}

SpinningLidar::SpinningLidar(const SpinningLidarSettings& settings, RandomStream random)
    : settings_(settings), random_(random), geometry_(geometry_of(settings)) {
    for (const double e_deg : geometry_.elevations_deg) {
        const double e_rad = e_deg * M_PI / 180;
        beams_.emplace_back(std::cos(e_rad), 0, std::sin(e_rad));
    }
    rays_.resize(beams_.size());
}

void SpinningLidar::aim(const Pose3& T_map_lidar, int column) {
    const Eigen::Matrix3d R_map_lidar = T_map_lidar.rotation.toRotationMatrix();
    const double a_rad = geometry_.azimuth_rad(column), c = std::cos(a_rad), s = std::sin(a_rad);
    for (std::size_t i = 0; i < beams_.size(); ++i) {
        const Eigen::Vector3d& beam = beams_[i];
        rays_[i] = {T_map_lidar.translation_m,
                    R_map_lidar * Eigen::Vector3d(c * beam.x(), s * beam.x(), beam.z())};
    }
}

/// Whatever of a body is nearer than what stands still.
void SpinningLidar::meet(const TriangleMesh& mesh, const Pose3& T_map_body) {
    const Pose3 T_body_map = T_map_body.inverse();
    for (std::size_t i = 0; i < rays_.size(); ++i) {
        const MeshRay ray{T_body_map * rays_[i].origin_m, T_body_map.rotation * rays_[i].direction};
        for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
            if (!meets_triangle(mesh, t, ray)) continue;
            const MeshHit hit = hit_on_triangle(mesh, t, ray);
            if (hit.range_m < hits_[i].range_m) hits_[i] = hit;
        }
    }
}

void SpinningLidar::look_at_bodies(StampNs time_ns, const MovingWorld& moving) {
    constexpr double radius_m = 4;  // of any vehicle, about its middle on the ground
    for (const MovingBody& body : moving.at(time_ns)) {
        const Eigen::Vector3d to_m = body.T_map_body.translation_m - rays_.front().origin_m;
        const double distance_m = to_m.norm();
        if (distance_m > settings_.max_range_m + radius_m) continue;
        // All beams of a column lie in one plane and on one side of its axis.
        const Eigen::Vector3d normal = rays_.front().direction.cross(rays_.back().direction).normalized();
        if (std::abs(normal.dot(to_m)) > radius_m) continue;
        const Eigen::Vector3d ahead = (rays_.front().direction + rays_.back().direction).normalized();
        if (ahead.dot(to_m) < -radius_m) continue;
        meet((*moving.meshes)[body.mesh], body.T_map_body);
    }
}

/// A surface sends back light by its reflectance and the cosine of incidence (Lambert); what arrives falls
/// with the square of the range.
std::uint16_t SpinningLidar::measured(const MeshHit& hit) {
    if (random_.chance(settings_.dropouts) || !std::isfinite(hit.range_m)) return 0;
    const Optics optics = optics_of(hit.material);
    const double part = hit.range_m / settings_.max_range_m;
    const double signal = optics.reflectance * hit.cosine / (part * part * settings_.least_reflectance);
    if (!random_.chance((1 - optics.lost) * std::clamp(signal - 0.5, 0.0, 1.0))) return 0;
    const double deeper_m = optics.depth_m > 0 ? random_.uniform(0, optics.depth_m) : 0;
    const double range_m = hit.range_m + deeper_m + random_.normal(settings_.sigma_range_m);
    if (range_m < settings_.min_range_m || range_m > settings_.max_range_m) return 0;
    return static_cast<std::uint16_t>(std::min(std::llround(range_m / range_unit_m), 65535LL));
}

const std::vector<std::uint16_t>& SpinningLidar::scan(StampNs start_ns,
                                                      const std::function<Pose3(StampNs)>& T_map_lidar,
                                                      const MeshCaster& world, const MovingWorld& moving) {
    const auto columns = static_cast<std::size_t>(geometry_.columns);
    ranges_.assign(beams_.size() * columns, 0);
    for (std::size_t column = 0; column < columns; ++column) {
        const auto k = static_cast<int>(column);
        const StampNs time_ns = start_ns + static_cast<StampNs>(std::llround(1e9 * geometry_.time_s(k)));
        aim(T_map_lidar(time_ns), k);
        // A surface just beyond the limit may still be measured within.
        world.cast(rays_, settings_.max_range_m + 6 * settings_.sigma_range_m, hits_);
        if (moving.at) look_at_bodies(time_ns, moving);
        for (std::size_t row = 0; row < beams_.size(); ++row)
            ranges_[row * columns + column] = measured(hits_[row]);
    }
    return ranges_;
}

}  // namespace loopline::simulation
