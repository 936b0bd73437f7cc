#include "maps/points_module.h"

namespace loopline {
IMPLEMENTS_MRPT_OBJECT(PointsMapBuilder, MapBuilder, loopline)

ModuleInfo PointsMapBuilder::info() const {
    return {"points",
            "Collects the points of all scans at their final poses, thinned.",
            {"CObservation2DRangeScan"},
            {},
            {}};
}

ParameterTable PointsMapBuilder::parameters() {
    return ParameterTable("points", info().sentence)
        .list("sensors", sensors_, "Labels of the lasers whose scans are used; empty for all.")
        .real("spacing_m", spacing_m_, {0.001, 100},
              "One point, the first, is kept in every cube with this edge.")
        .real("max_range_m", max_range_m_, {0.1, 10000}, "Returns from farther away are not used.")
        .integer("max_points", max_points_, {1, 1e9},
                 "Points beyond this number are left out; one takes about 60 bytes of memory while the map "
                 "is drawn.");
}

void PointsMapBuilder::start(const RunContext&, const Trajectory& trajectory) {
    trajectory_ = &trajectory;
    points_ = mrpt::maps::CSimplePointsMap::Create();
    taken_ = std::make_shared<maps::VoxelSet>(spacing_m_);
    left_out_ = 0;
}

void PointsMapBuilder::insert(const StreamItem& item) {
    if (!scan_.take(item, *trajectory_, sensors_)) return;
    const PlanarScan& beams = scan_.beams();
    const Eigen::Matrix3d R_map_sensor = scan_.T_map_sensor().rotation.toRotationMatrix();
    for (std::size_t beam = 0; beam < beams.size(); ++beam) {
        if (!beams.has_return(beam) || beams.ranges_m[beam] > max_range_m_) continue;
        const Eigen::Vector2d p_sensor = beams.point_sensor_m(beam);
        const Eigen::Vector3d p_map =
            R_map_sensor.leftCols<2>() * p_sensor + scan_.T_map_sensor().translation_m;
        if (static_cast<std::int64_t>(points_->size()) >= max_points_) {
            ++left_out_;
            continue;
        }
        if (taken_->take(p_map))
            points_->insertPointFast(static_cast<float>(p_map.x()), static_cast<float>(p_map.y()),
                                     static_cast<float>(p_map.z()));
    }
}

void PointsMapBuilder::finish(Results& results) {
    points_->mark_as_modified();  // insertPointFast() leaves MRPT's caches as they were
    results.metrics["points"] = static_cast<std::int64_t>(points_->size());
    if (left_out_ > 0) results.metrics["points_left_out"] = left_out_;
    results.maps.push_back({info().name, points_});
    points_.reset();
    taken_.reset();
}

}  // namespace loopline
