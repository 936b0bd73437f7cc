#include "lidar/observation_scan.h"

#include <mrpt/maps/CPointsMapXYZI.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/obs/CObservationRotatingScan.h>
#include <mrpt/obs/CObservationVelodyneScan.h>

#include <algorithm>
#include <cmath>

#include "api/mrpt_pose.h"
#include "api/observation_class.h"
#include "lidar/beam_table.h"

namespace loopline::lidar {
namespace {

constexpr float least_level_m = 0.05f;  ///< what is nearer to the axis is the lidar itself

/// 255 becomes 65535.
std::uint16_t of_full_scale(std::uint8_t byte) {
    return static_cast<std::uint16_t>(byte * 257);
}
/// 1 becomes 65535.
std::uint16_t of_full_scale(float part) {
    return part > 0 ? static_cast<std::uint16_t>(std::min(part, 1.0f) * 65535 + 0.5f) : std::uint16_t{0};
}

/// MRPT 2.5 makes an image of Velodyne's packets with a column for each beam of each firing, and fills one a
/// firing, in the front; and it keeps Velodyne's azimuths, which count clockwise.
bool made_of_packets(const mrpt::obs::CObservationRotatingScan& image) {
    const auto rows = image.rangeImage.rows(), columns = image.rangeImage.cols();
    if (columns % rows != 0 || columns / rows < 2) return false;
    for (auto row = 0 * rows; row < rows; ++row)
        for (auto k = columns / rows; k < columns; ++k)
            if (image.rangeImage(row, k) != 0) return false;
    return true;
}

}  // namespace

std::shared_ptr<mrpt::obs::CObservationRotatingScan> rotating_scan(const RangeImageGeometry& geometry,
                                                                   const std::string& model,
                                                                   const std::vector<std::uint16_t>& ranges) {
    auto image = mrpt::obs::CObservationRotatingScan::Create();
    const std::size_t rows = geometry.elevations_deg.size();
    image->rowCount = static_cast<std::uint16_t>(rows);
    image->columnCount = static_cast<std::uint16_t>(geometry.columns);
    image->rangeImage.resize(rows, geometry.columns);
    std::copy(ranges.begin(), ranges.end(), &image->rangeImage(0, 0));
    image->rangeResolution = geometry.range_unit_m;
    image->startAzimuth = geometry.first_azimuth_rad;
    image->azimuthSpan = geometry.azimuth_span_rad;
    image->sweepDuration = geometry.sweep_s;
    image->lidarModel = text_of({model, geometry.elevations_deg});
    return image;
}

bool SpinningScanReader::read(const mrpt::obs::CObservation& observation, SpinningScan& scan,
                              Intensity* intensity) {
    scan.clear();
    if (intensity != nullptr) intensity->clear();
    const auto stamp_ns = stamp_from_mrpt(observation.timestamp);
    if (!stamp_ns) return false;
    bool known = false;
    if (const auto* image = as<mrpt::obs::CObservationRotatingScan>(&observation))
        known = read_image(*image, scan, intensity);
    else if (const auto* packets = as<mrpt::obs::CObservationVelodyneScan>(&observation))
        known = packets_.read(*packets, scan, intensity);
    else if (const auto* cloud = as<mrpt::obs::CObservationPointCloud>(&observation))
        known = read_points(*cloud, scan, intensity);
    if (!known || scan.points.empty()) {
        scan.clear();
        return false;
    }
    mrpt::poses::CPose3D sensor_pose;
    observation.getSensorPose(sensor_pose);
    scan.T_base_lidar = pose3_from_mrpt(sensor_pose);
    scan.label = observation.sensorLabel;
    scan.stamp_ns = *stamp_ns;
    return true;
}

bool SpinningScanReader::read_image(const mrpt::obs::CObservationRotatingScan& image, SpinningScan& scan,
                                    Intensity* intensity) {
    if (image.lidarModel != model_) {
        const auto table = table_from_text(image.lidarModel);
        geometry_.elevations_deg = table ? table->elevations_deg : std::vector<double>{};
        model_ = image.lidarModel;
    }
    const auto rows = image.rangeImage.rows(), columns = image.rangeImage.cols();
    const double numbers[] = {image.startAzimuth, image.azimuthSpan, image.sweepDuration,
                              image.rangeResolution};
    for (const double number : numbers)
        if (!std::isfinite(number)) return false;
    if (rows == 0 || columns == 0 || geometry_.elevations_deg.size() != static_cast<std::size_t>(rows))
        return false;
    geometry_.columns = static_cast<int>(columns);
    geometry_.first_azimuth_rad = image.startAzimuth;
    geometry_.azimuth_span_rad = image.azimuthSpan;
    geometry_.sweep_s = image.sweepDuration;
    geometry_.range_unit_m = image.rangeResolution;
    if (made_of_packets(image)) {
        geometry_.columns /= static_cast<int>(rows);
        geometry_.first_azimuth_rad *= -1;
        geometry_.azimuth_span_rad *= -1;
    }
    images_.read(geometry_, &image.rangeImage(0, 0), static_cast<std::size_t>(columns), scan);
    if (intensity != nullptr && image.intensityImage.rows() == rows && image.intensityImage.cols() == columns)
        for (const int row : from_high_to_low(geometry_.elevations_deg))
            for (int k = 0; k < geometry_.columns; ++k)
                if (image.rangeImage(row, k) != 0)
                    intensity->push_back(of_full_scale(image.intensityImage(row, k)));
    return true;
}

bool SpinningScanReader::read_points(const mrpt::obs::CObservationPointCloud& cloud, SpinningScan& scan,
                                     Intensity* intensity) {
    cloud.load();
    if (!cloud.pointcloud) return false;
    const auto& x_m = cloud.pointcloud->getPointsBufferRef_x();
    const auto& y_m = cloud.pointcloud->getPointsBufferRef_y();
    const auto& z_m = cloud.pointcloud->getPointsBufferRef_z();
    const auto* with_intensity = intensity != nullptr
                                     ? dynamic_cast<const mrpt::maps::CPointsMapXYZI*>(cloud.pointcloud.get())
                                     : nullptr;
    std::vector<std::uint16_t> as_stored;
    points_m_.clear();
    for (std::size_t i = 0; i < x_m.size(); ++i) {
        // KITTI's files end with a point at the origin, which is none.
        const float level_m2 = x_m[i] * x_m[i] + y_m[i] * y_m[i];
        if (!(level_m2 > least_level_m * least_level_m && std::isfinite(level_m2) && std::isfinite(z_m[i])))
            continue;
        points_m_.emplace_back(x_m[i], y_m[i], z_m[i]);
        if (with_intensity != nullptr)
            as_stored.push_back(of_full_scale(with_intensity->getPointIntensity_fast(i)));
    }
    std::vector<std::uint32_t> sources;
    clouds_.read(points_m_, cloud_sweep_, scan, with_intensity != nullptr ? &sources : nullptr);
    for (const std::uint32_t source : sources) intensity->push_back(as_stored[source]);
    return true;
}

}  // namespace loopline::lidar
