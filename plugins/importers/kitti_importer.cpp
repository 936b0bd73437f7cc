#include "importers/kitti_importer.h"

#include <mrpt/maps/CPointsMapXYZI.h>
#include <mrpt/obs/CObservationGPS.h>
#include <mrpt/obs/CObservationIMU.h>
#include <mrpt/obs/CObservationPointCloud.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "importers/kitti_files.h"

namespace loopline {
IMPLEMENTS_MRPT_OBJECT(KittiImporter, Importer, loopline)

namespace fs = std::filesystem;

struct KittiImporter::Recording {
    std::vector<fs::path> scans, oxts;
    std::vector<StampNs> scan_times_ns, oxts_times_ns;
    std::vector<Pose3> T_map_lidar;
};

namespace {

void expect_as_many(const std::string& what, std::size_t found, std::size_t scans,
                    const std::string& folder) {
    if (found < scans)
        throw std::runtime_error(what + " has " + std::to_string(found) + " lines for " +
                                 std::to_string(scans) + " scans in " + folder);
}

/// A file or folder that was named, or one that lies where KITTI puts it.
std::string named_or_beside(const std::string& named, const fs::path& scans,
                            std::initializer_list<const char*> names) {
    if (!named.empty()) return named;
    for (const char* name : names)
        if (const auto found = kitti::beside(scans, name)) return found->string();
    return {};
}

std::shared_ptr<mrpt::obs::CObservationPointCloud> cloud_of(const std::vector<kitti::BinPoint>& points,
                                                            StampNs stamp_ns) {
    auto map = mrpt::maps::CPointsMapXYZI::Create();
    map->resize(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
        map->setPointFast(i, points[i].x_m, points[i].y_m, points[i].z_m);
        map->setPointIntensity(i, points[i].reflectance);
    }
    auto cloud = mrpt::obs::CObservationPointCloud::Create();
    cloud->sensorLabel = "velodyne";
    cloud->timestamp = stamp_to_mrpt(stamp_ns);
    cloud->pointcloud = map;
    return cloud;
}

mrpt::obs::CObservationIMU imu_of(const kitti::Oxts& oxts, StampNs stamp_ns) {
    mrpt::obs::CObservationIMU imu;
    imu.sensorLabel = "oxts_imu";
    imu.timestamp = stamp_to_mrpt(stamp_ns);
    imu.set(mrpt::obs::IMU_X_ACC, oxts.acceleration_mps2.x());
    imu.set(mrpt::obs::IMU_Y_ACC, oxts.acceleration_mps2.y());
    imu.set(mrpt::obs::IMU_Z_ACC, oxts.acceleration_mps2.z());
    imu.set(mrpt::obs::IMU_WX, oxts.turn_radps.x());
    imu.set(mrpt::obs::IMU_WY, oxts.turn_radps.y());
    imu.set(mrpt::obs::IMU_WZ, oxts.turn_radps.z());
    return imu;
}

mrpt::obs::CObservationGPS gnss_of(const kitti::Oxts& oxts, StampNs stamp_ns) {
    mrpt::obs::CObservationGPS gnss;
    gnss.sensorLabel = "oxts_gnss";
    gnss.timestamp = gnss.originalReceivedTimestamp = stamp_to_mrpt(stamp_ns);
    gnss.has_satellite_timestamp = true;
    mrpt::obs::gnss::Message_NMEA_GGA gga;
    const StampNs of_day_ns = stamp_ns % (24LL * 3600 * 1'000'000'000);
    gga.fields.UTCTime.hour = static_cast<std::uint8_t>(of_day_ns / 3'600'000'000'000);
    gga.fields.UTCTime.minute = static_cast<std::uint8_t>(of_day_ns / 60'000'000'000 % 60);
    gga.fields.UTCTime.sec = static_cast<double>(of_day_ns % 60'000'000'000) * 1e-9;
    gga.fields.latitude_degrees = oxts.latitude_deg;
    gga.fields.longitude_degrees = oxts.longitude_deg;
    gga.fields.altitude_meters = oxts.altitude_m;
    gga.fields.fix_quality = 1;
    gga.fields.satellitesUsed = static_cast<std::uint32_t>(std::max(oxts.satellites, 0));
    gnss.setMsg(gga);
    return gnss;
}

}  // namespace

ModuleInfo KittiImporter::info() const {
    return {"kitti",
            "Folders of KITTI: scans (.bin), and times, poses and oxts where they lie beside them.",
            {},
            {},
            {"CObservationPointCloud", "CObservationIMU", "CObservationGPS"}};
}

ParameterTable KittiImporter::parameters() {
    return ParameterTable("kitti", info().sentence)
        .text("times", times_,
              "Times of the scans; else times.txt or timestamps.txt beside them, else rate_hz.")
        .text("poses", poses_,
              "The camera's true poses, written to F.truth.tum as the lidar's; else poses.txt beside the "
              "scans.")
        .text("oxts", oxts_, "Folder of GNSS and IMU; else oxts beside the scans.")
        .real("rate_hz", rate_hz_, {0.1, 1000}, "Scans a second, where no times are known.")
        .real("start_s", start_s_, {0, 4e9},
              "Seconds since 1970 of the first scan where times are not known, or count from it.");
}

KittiImporter::Recording KittiImporter::recording_in(const std::string& folder, RawlogSink& sink) const {
    Recording recording;
    recording.scans = kitti::bin_files(folder);
    if (recording.scans.empty()) throw std::runtime_error("there is no .bin file in " + folder);
    const std::size_t scans = recording.scans.size();
    const fs::path at = recording.scans.front().parent_path();
    const auto start_ns = static_cast<StampNs>(std::llround(start_s_ * 1e7)) * 100;
    if (const auto times = named_or_beside(times_, at, {"times.txt", "timestamps.txt", "timestamps.csv"});
        !times.empty()) {
        recording.scan_times_ns = kitti::read_times(times);
        expect_as_many(times, recording.scan_times_ns.size(), scans, folder);
        constexpr StampNs day_ns = 86'400'000'000'000;  // no date: they count from the first scan
        if (recording.scan_times_ns.front() < day_ns)
            for (StampNs& time_ns : recording.scan_times_ns) time_ns += start_ns;
    } else {
        sink.warn("there are no times, so scans are taken to follow each other at " + number_text(rate_hz_) +
                  " Hz");
        for (std::size_t i = 0; i < scans; ++i)
            recording.scan_times_ns.push_back(
                start_ns + static_cast<StampNs>(std::llround(static_cast<double>(i) / rate_hz_ * 1e9)));
    }
    if (const auto poses = named_or_beside(poses_, at, {"poses.txt"}); !poses.empty()) {
        const auto calibration = kitti::beside(at, "calib.txt");
        if (!calibration) sink.warn("there is no calib.txt, so the lidar is taken to be where the camera is");
        recording.T_map_lidar = kitti::read_lidar_poses(
            poses, calibration ? kitti::read_T_camera_lidar(*calibration) : kitti::axes_camera_lidar());
        expect_as_many(poses, recording.T_map_lidar.size(), scans, folder);
    }
    if (const auto oxts = named_or_beside(oxts_, at, {"oxts"}); !oxts.empty()) {
        recording.oxts = kitti::oxts_files(oxts);
        if (recording.oxts.empty()) throw std::runtime_error("there are no .txt files in " + oxts);
        const auto times = kitti::beside(recording.oxts.front().parent_path(), "timestamps.txt");
        if (!times) throw std::runtime_error("there is no timestamps.txt in " + oxts);
        recording.oxts_times_ns = kitti::read_times(*times);
        expect_as_many(times->string(), recording.oxts_times_ns.size(), recording.oxts.size(), oxts);
    }
    return recording;
}

void KittiImporter::write(const Recording& recording, RawlogSink& sink) const {
    std::size_t packet = 0;
    const auto write_packet = [&] {
        const kitti::Oxts oxts = kitti::read_oxts(recording.oxts[packet]);
        sink.write(imu_of(oxts, recording.oxts_times_ns[packet]));
        sink.write(gnss_of(oxts, recording.oxts_times_ns[packet]));
        ++packet;
    };
    for (std::size_t i = 0; i < recording.scans.size(); ++i) {
        const StampNs stamp_ns = recording.scan_times_ns[i];
        while (packet < recording.oxts.size() && recording.oxts_times_ns[packet] <= stamp_ns) write_packet();
        sink.write(*cloud_of(kitti::read_bin(recording.scans[i]), stamp_ns));
        if (!recording.T_map_lidar.empty()) sink.true_pose(stamp_ns, recording.T_map_lidar[i]);
    }
    while (packet < recording.oxts.size()) write_packet();
}

std::string KittiImporter::import(const std::vector<std::string>& inputs, RawlogSink& sink) {
    std::size_t scans = 0, packets = 0;
    for (const auto& folder : inputs) {
        const Recording recording = recording_in(folder, sink);
        write(recording, sink);
        scans += recording.scans.size();
        packets += recording.oxts.size();
    }
    return std::to_string(scans) + " scans" +
           (packets > 0 ? ", " + std::to_string(packets) + " of GNSS and IMU" : std::string());
}

}  // namespace loopline
