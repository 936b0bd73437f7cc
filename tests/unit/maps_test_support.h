/// Scans for the map builders' tests.
#pragma once

#include <mrpt/obs/CObservation2DRangeScan.h>

#include <algorithm>
#include <memory>
#include <random>
#include <vector>

#include "api/module.h"

namespace maps_test {

/// A scan of `ranges_m`; 0 is an invalid beam.
inline mrpt::obs::CObservation2DRangeScan::Ptr scan_of(const std::vector<float>& ranges_m,
                                                       double aperture_rad,
                                                       const mrpt::poses::CPose3D& T_base_sensor = {},
                                                       bool counter_clockwise = true) {
    auto scan = mrpt::obs::CObservation2DRangeScan::Create();
    std::vector<char> valid;
    for (const float r : ranges_m) valid.push_back(r > 0);
    scan->aperture = static_cast<float>(aperture_rad);
    scan->maxRange = 80;
    scan->rightToLeft = counter_clockwise;
    scan->sensorPose = T_base_sensor;
    scan->sensorLabel = "LASER";
    scan->loadFromVectors(ranges_m.size(), ranges_m.data(), valid.data());
    return scan;
}

/// About one beam in `one_in` has a return, between 1 and 25 m.
inline std::vector<float> sparse_ranges(std::size_t size, int one_in, std::mt19937_64& random) {
    std::vector<float> ranges(size, 0.0f);
    std::uniform_real_distribution<float> range(1, 25);
    for (float& r : ranges)
        if (random() % static_cast<unsigned>(one_in) == 0) r = range(random);
    return ranges;
}

/// Where the returns lie in the map, in counter-clockwise order as the sensor sees it, by MRPT's definition
/// of a scan and its own 4x4 transforms: the truth for the builders.
inline std::vector<Eigen::Vector3d> points_in_map(const mrpt::obs::CObservation2DRangeScan& scan,
                                                  const mrpt::poses::CPose3D& T_map_base) {
    std::vector<Eigen::Vector3d> points;
    const mrpt::poses::CPose3D T_map_sensor = T_map_base + scan.sensorPose;
    const std::size_t size = scan.getScanSize();
    for (std::size_t beam = 0; beam < size; ++beam) {
        const std::size_t i = scan.rightToLeft ? beam : size - 1 - beam;
        if (!scan.getScanRangeValidity(i)) continue;
        const double along = static_cast<double>(i) / static_cast<double>(size - 1) - 0.5;
        const double angle = static_cast<double>(scan.aperture) * along * (scan.rightToLeft ? 1 : -1);
        const double r = scan.getScanRange(i);
        Eigen::Vector3d p;
        T_map_sensor.composePoint(r * std::cos(angle), r * std::sin(angle), 0, p.x(), p.y(), p.z());
        points.push_back(p);
    }
    return points;
}

inline loopline::StreamItem item_of(std::uint64_t sequence, mrpt::obs::CObservation::Ptr observation) {
    return {sequence, static_cast<loopline::StampNs>(sequence) * 1000, std::move(observation)};
}

/// Sets a parameter as an .ini would.
inline void set(loopline::Configurable& builder, const std::string& key, const std::string& value) {
    const auto table = builder.parameters();
    ASSERT_NE(table.find(key), nullptr) << key;
    ASSERT_FALSE(table.find(key)->parse(value)) << key << " = " << value;
}

template <class Map>
std::shared_ptr<Map> only_map(const loopline::Results& results) {
    EXPECT_EQ(results.maps.size(), 1u);
    return results.maps.empty() ? nullptr : std::dynamic_pointer_cast<Map>(results.maps[0].map);
}

}  // namespace maps_test
