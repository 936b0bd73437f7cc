/// What a run in memory has to show.
#include "render/scene_content.h"

#include <mrpt/maps/CPointsMap.h>

#include "pipeline/run_record.h"

namespace loopline {
namespace {

std::vector<Pose3> poses_of(const Trajectory* trajectory) {
    std::vector<Pose3> poses;
    if (!trajectory) return poses;
    poses.reserve(trajectory->size());
    for (const auto& entry : trajectory->entries())
        if (entry.T_map_base.translation_m.allFinite() && entry.T_map_base.rotation.coeffs().allFinite())
            poses.push_back(entry.T_map_base);
    return poses;
}

void add_points(const Results& results, std::vector<Eigen::Vector3f>& points_m) {
    for (const auto& named : results.maps) {
        const auto map = std::dynamic_pointer_cast<mrpt::maps::CPointsMap>(named.map);
        if (!map || named.survey) continue;
        const auto& x = map->getPointsBufferRef_x();
        const auto& y = map->getPointsBufferRef_y();
        const auto& z = map->getPointsBufferRef_z();
        points_m.reserve(points_m.size() + x.size());
        for (std::size_t i = 0; i < x.size(); ++i) {
            const Eigen::Vector3f p(x[i], y[i], z[i]);
            if (p.allFinite()) points_m.push_back(p);
        }
    }
}

std::vector<SurveyCloud> surveys_of(const RunRecord& record) {
    const auto cloud_named = [](const Results& results, const std::string& name) {
        mrpt::maps::CPointsMap::Ptr cloud;
        for (const auto& named : results.maps)
            if (named.survey && named.name == name)
                cloud = std::dynamic_pointer_cast<mrpt::maps::CPointsMap>(named.map);
        return cloud;
    };
    std::vector<SurveyCloud> surveys;
    for (const auto& named : record.results.maps)
        if (auto cloud = cloud_named(record.results, named.name))
            surveys.push_back({named.name, cloud, cloud_named(record.odometry_results, named.name)});
    return surveys;
}

}  // namespace

SceneContent scene_from_record(const RunRecord& record, const std::string& title) {
    SceneContent content;
    content.title = title;
    content.estimated_path = poses_of(record.trajectory);
    content.odometry_path = poses_of(record.odometry);
    content.lines = record.results.line_map;
    add_points(record.results, content.points_m);
    add_points(record.odometry_results, content.points_odometry_m);
    content.surveys = surveys_of(record);
    if (record.cloud != nullptr) content.cloud = std::make_shared<PointsOfCloud>(*record.cloud);
    // A path on the Earth is not to be seen over a cloud that is not.
    if (record.cloud != nullptr && record.results.earth && !record.cloud_on_trajectory)
        content.estimated_path.clear();
    for (const auto& named : record.results.maps)
        if (!content.grid)
            content.grid = std::dynamic_pointer_cast<mrpt::maps::COccupancyGridMap2D>(named.map);
    return content;
}

}  // namespace loopline
