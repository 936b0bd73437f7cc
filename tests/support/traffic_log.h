/// Sweeps of a lidar in a simulated town, with the truth on each return: whether it is of something that
/// moves.
#pragma once

#include <functional>
#include <optional>

#include "api/stored_cloud.h"
#include "support/simulated_scene.h"

namespace loopline::test {

class TrafficLog {
 public:
    TrafficLog(const std::string& scenario_file, const std::vector<std::string>& overrides) {
        load_scenario(scenario_file, overrides, simulator_);
        scene_ = simulation::make_scene(simulator_.scenario());
        for (const simulation::TriangleMesh& mesh : scene_->landscape->traffic.meshes()) {
            Eigen::AlignedBox3d box;
            for (const Eigen::Vector3f& p : mesh.vertices_m) box.extend(p.cast<double>());
            boxes_.push_back(box);
        }
    }

    /// Calls `use(observation)` for each sweep, in order.
    void for_each_sweep(const std::function<void(const mrpt::obs::CObservation::Ptr&)>& use) {
        for (simulation::Sensor* sensor : simulator_.sensors_in_use()) {
            sensor->start(*scene_);
            while (sensor->next_time_ns() <= scene_->duration_ns()) use(sensor->next());
        }
    }
    std::optional<Pose3> T_map_base(StampNs stamp_ns) const {
        return scene_->drive.motion.pose_at(stamp_ns - scene_->start_ns);
    }

    enum class Kind { still, moving, unclear };
    /// Of a return at a place and time. Unclear is what lies about the foot of a car.
    Kind kind(const Eigen::Vector3d& p_map_m, StampNs stamp_ns) const {
        constexpr double noise_m = 0.08, foot_m = 0.12;
        for (const auto& body : scene_->landscape->traffic.at(stamp_ns - scene_->start_ns)) {
            const Eigen::Vector3d p = body.T_map_body.inverse() * p_map_m;
            Eigen::AlignedBox3d box = boxes_[body.mesh];
            box.extend(box.min() - Eigen::Vector3d::Constant(noise_m));
            box.extend(box.max() + Eigen::Vector3d::Constant(noise_m));
            if (box.contains(p)) return p.z() < foot_m ? Kind::unclear : Kind::moving;
        }
        return Kind::still;
    }

    struct Count {
        std::size_t still = 0, moving = 0;
    };
    Count count(const StoredCloud& cloud) const {
        Count count;
        for (const CloudPoint& point : cloud.points()) {
            const Kind k = kind(point.p_map_m(), cloud.first_ns + std::llround(1e9 * point.time_s()));
            count.still += k == Kind::still ? 1 : 0;
            count.moving += k == Kind::moving ? 1 : 0;
        }
        return count;
    }

 private:
    WorldSimulator simulator_;
    std::unique_ptr<simulation::Scene> scene_;
    std::vector<Eigen::AlignedBox3d> boxes_;
};

}  // namespace loopline::test
