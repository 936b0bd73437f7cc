/// What module cloud_map leaves out of a town with traffic, how much of what stands is bare without that, and
/// what it costs, with true poses:
///   cloud_map_score SCENARIO.ini [SCENARIO_SECTION.KEY=VALUE]... [cloud_map.KEY=VALUE]...
#include <mrpt/obs/CObservationRobotPose.h>
#include <sys/resource.h>

#include <chrono>
#include <cstdio>
#include <unordered_map>

#include "cloud_map/cloud_map_module.h"
#include "support/traffic_log.h"

using namespace loopline;

namespace {

struct Outcome {
    test::TrafficLog::Count count;
    std::vector<Eigen::Vector3d> still_m;
    double voxel_m = 0;
    std::map<std::string, MetricValue> metrics;
    double sweep_ms = 0, worst_ms = 0;
};

class NoPublisher : public Publisher {
    void publish(const mrpt::obs::CObservation::Ptr&) override {}
    void publish(const mrpt::obs::CObservation::Ptr&, std::uint64_t) override {}
};

void set(CloudMapModule& module, const std::string& key, const std::string& value) {
    const auto table = module.parameters();
    const Parameter* parameter = table.find(key);
    if (parameter == nullptr || parameter->parse(value)) throw std::runtime_error("cloud_map." + key + "?");
}

Outcome run(const test::TrafficLog& log, const std::vector<mrpt::obs::CObservation::Ptr>& sweeps,
            const std::vector<std::pair<std::string, std::string>>& keys, bool remove_moving) {
    CloudMapModule module;
    for (const auto& [key, value] : keys) set(module, key, value);
    if (!remove_moving) set(module, "remove_moving", "false");
    RunContext context;
    context.threads = 2;
    module.start(context);
    Outcome outcome;
    NoPublisher publisher;
    std::uint64_t sequence = 0;
    for (const auto& sweep : sweeps) {
        const StampNs stamp_ns = *stamp_from_mrpt(sweep->timestamp);
        auto pose = mrpt::obs::CObservationRobotPose::Create();
        const Pose3 T = *log.T_map_base(stamp_ns);
        const auto& q = T.rotation;
        pose->pose.mean = mrpt::poses::CPose3D(mrpt::math::CQuaternionDouble(q.w(), q.x(), q.y(), q.z()),
                                               T.translation_m.x(), T.translation_m.y(), T.translation_m.z());
        pose->timestamp = sweep->timestamp;
        pose->sensorLabel = "lidar_mapping";
        const auto start = std::chrono::steady_clock::now();
        module.process({sequence, stamp_ns, sweep, false}, publisher);
        module.process({sequence, stamp_ns, pose, true}, publisher);
        const double ms =
            std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
        outcome.sweep_ms += ms / double(sweeps.size());
        outcome.worst_ms = std::max(outcome.worst_ms, ms);
        ++sequence;
    }
    Results results;
    module.finish(results);
    outcome.metrics = results.metrics;
    outcome.count = log.count(*module.cloud());
    const StoredCloud& cloud = *module.cloud();
    for (const CloudPoint& point : cloud.points()) {
        const StampNs seen_ns = cloud.first_ns + std::llround(1e9 * point.time_s());
        if (log.kind(point.p_map_m(), seen_ns) == test::TrafficLog::Kind::still)
            outcome.still_m.push_back(point.p_map_m());
    }
    const ParameterTable table = module.parameters();
    outcome.voxel_m = std::stod(table.find("voxel_m")->print());
    return outcome;
}

/// How many of `all` have none of `kept` within `reach_m`.
std::size_t count_bare(const std::vector<Eigen::Vector3d>& all, const std::vector<Eigen::Vector3d>& kept,
                       double reach_m) {
    const auto cube_of = [&](const Eigen::Vector3d& p_m) {
        return cloud_map::CubeIndex{static_cast<std::int32_t>(std::floor(p_m.x() / reach_m)),
                                    static_cast<std::int32_t>(std::floor(p_m.y() / reach_m)),
                                    static_cast<std::int32_t>(std::floor(p_m.z() / reach_m))};
    };
    std::unordered_multimap<std::uint64_t, std::size_t> cubes;
    cubes.reserve(kept.size());
    for (std::size_t k = 0; k < kept.size(); ++k) cubes.emplace(cloud_map::pack(cube_of(kept[k])), k);
    std::size_t bare = 0;
    for (const Eigen::Vector3d& p_m : all) {
        const auto [x, y, z] = cube_of(p_m);
        bool is_near = false;
        for (int step = 0; step < 27 && !is_near; ++step) {
            const auto [first, end] = cubes.equal_range(
                cloud_map::pack({x + step / 9 - 1, y + step / 3 % 3 - 1, z + step % 3 - 1}));
            for (auto k = first; k != end && !is_near; ++k)
                is_near = (kept[k->second] - p_m).squaredNorm() < reach_m * reach_m;
        }
        bare += is_near ? 0 : 1;
    }
    return bare;
}

}  // namespace

int main(int argc, char** argv) {
    if (argc < 2) return 2;
    std::vector<std::string> overrides;
    std::vector<std::pair<std::string, std::string>> keys;
    for (int i = 2; i < argc; ++i) {
        const std::string word = argv[i], prefix = "cloud_map.";
        if (word.rfind(prefix, 0) != 0) {
            overrides.push_back(word);
            continue;
        }
        const auto equals = word.find('=');
        keys.emplace_back(word.substr(prefix.size(), equals - prefix.size()), word.substr(equals + 1));
    }
    test::TrafficLog log(argv[1], overrides);
    std::vector<mrpt::obs::CObservation::Ptr> sweeps;
    log.for_each_sweep([&](const auto& sweep) { sweeps.push_back(sweep); });
    const Outcome all = run(log, sweeps, keys, false), kept = run(log, sweeps, keys, true);
    std::printf("%zu sweeps\n%-22s %12s %12s %10s %10s\n", sweeps.size(), "", "still", "moving", "ms/sweep",
                "worst ms");
    for (const auto* o : {&all, &kept})
        std::printf("%-22s %12zu %12zu %10.2f %10.2f\n", o == &all ? "all points" : "moving ones removed",
                    o->count.still, o->count.moving, o->sweep_ms, o->worst_ms);
    std::printf(
        "still points kept: %.3f %%, moving points removed: %.2f %%\n",
        100.0 * double(kept.count.still) / double(std::max<std::size_t>(1, all.count.still)),
        100.0 - 100.0 * double(kept.count.moving) / double(std::max<std::size_t>(1, all.count.moving)));
    std::printf("still points with none kept within 2 voxel_m: %.3f %%\n",
                100.0 * double(count_bare(all.still_m, kept.still_m, 2 * all.voxel_m)) /
                    double(std::max<std::size_t>(1, all.still_m.size())));
    for (const auto& [key, value] : kept.metrics)
        if (const auto* count = std::get_if<std::int64_t>(&value))
            std::printf("%s %lld\n", key.c_str(), static_cast<long long>(*count));
}
