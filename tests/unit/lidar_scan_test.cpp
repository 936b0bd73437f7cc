/// Scans of spinning lidars out of observations: every class that holds them gives the same points, rings and
/// times.
#include <gtest/gtest.h>
#include <mrpt/io/CFileGZInputStream.h>
#include <mrpt/io/CMemoryStream.h>
#include <mrpt/maps/CPointsMapXYZI.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/obs/CObservationRotatingScan.h>
#include <mrpt/obs/CObservationVelodyneScan.h>
#include <mrpt/serialization/CArchive.h>

#include <cmath>
#include <filesystem>

#include "lidar/beam_table.h"
#include "lidar/observation_scan.h"
#include "support/velodyne_packets.h"

using namespace loopline;
using namespace loopline::lidar;

namespace {

/// A turn clockwise from behind, as of a VLP-16.
RangeImageGeometry small_image(int columns) {
    RangeImageGeometry geometry;
    geometry.columns = columns;
    geometry.first_azimuth_rad = M_PI;
    geometry.azimuth_span_rad = -2 * M_PI * (columns - 1) / columns;
    geometry.sweep_s = 0.1 * (columns - 1) / columns;
    geometry.range_unit_m = 0.002;
    geometry.elevations_deg = table_of_beams(16)->elevations_deg;
    return geometry;
}

/// Sorts nothing: as a file of KITTI is stored, a ring after the other, counter-clockwise from ahead.
std::vector<Eigen::Vector3f> stored_like_kitti(const std::vector<double>& elevations_deg, int columns) {
    std::vector<Eigen::Vector3f> points_m;
    for (const double e_deg : elevations_deg)
        for (int k = 0; k < columns; ++k) {
            if (k % 7 == 3) continue;  // no return
            const double a = 2 * M_PI * (k + 0.3) / columns, e = e_deg * M_PI / 180,
                         r_m = 10 + 5 * std::sin(3 * a);
            points_m.emplace_back(r_m * std::cos(e) * std::cos(a), r_m * std::cos(e) * std::sin(a),
                                  r_m * std::sin(e));
        }
    return points_m;
}

std::size_t rings_in_order(const std::vector<Eigen::Vector3f>& points_m) {
    std::vector<BeamDirection> directions;
    RingsOfCloud found;
    find_directions(points_m, directions);
    find_rings_by_order(directions, found);
    return found.rings;
}

void expect_rings_of_their_own(const SpinningScan& scan, const std::vector<double>& elevations_deg) {
    ASSERT_EQ(scan.rings(), elevations_deg.size());
    for (std::size_t ring = 0; ring < scan.rings(); ++ring)
        for (std::uint32_t i = scan.ring_begin[ring]; i < scan.ring_begin[ring + 1]; ++i) {
            const SpinningPoint& p = scan.points[i];
            ASSERT_NEAR(std::atan2(p.z_m, std::hypot(p.x_m, p.y_m)) * 180 / M_PI, elevations_deg[ring], 1e-3);
            const std::uint32_t before = std::max(i, scan.ring_begin[ring] + 1) - 1;
            ASSERT_GE(p.time_s, scan.points[before].time_s);
        }
}

mrpt::obs::CObservation::Ptr first_observation(const std::string& file) {
    mrpt::io::CFileGZInputStream stream;
    stream.open(file);
    auto archive = mrpt::serialization::archiveFrom(stream);
    return std::dynamic_pointer_cast<mrpt::obs::CObservation>(archive.ReadObject());
}

const char* const samples = "/usr/share/mrpt/datasets/";

}  // namespace

TEST(BeamTable, survives_its_text) {
    for (const int beams : {16, 32, 64}) {
        const auto table = table_of_beams(beams);
        ASSERT_TRUE(table);
        EXPECT_EQ(table->elevations_deg.size(), static_cast<std::size_t>(beams));
        const auto again = table_from_text(text_of(*table));
        ASSERT_TRUE(again);
        EXPECT_EQ(again->model, table->model);
        EXPECT_EQ(again->elevations_deg, table->elevations_deg);
    }
    EXPECT_EQ(table_of_beams(64)->elevations_deg.front(), 2);
    EXPECT_NEAR(table_of_beams(64)->elevations_deg.back(), -24.33, 0.01);
    EXPECT_FALSE(table_of_beams(17));
    EXPECT_FALSE(table_from_text("UNKNOWN_SCANNER"));
    EXPECT_FALSE(table_from_text("X elevations_deg 1 two"));
    EXPECT_EQ(table_from_text("VLP-16")->elevations_deg[3], 3) << "Velodyne's order of lasers";
}

TEST(RangeImage, survives_a_rawlog) {
    const RangeImageGeometry geometry = small_image(90);
    std::vector<std::uint16_t> ranges(16 * 90);
    for (std::size_t i = 0; i < ranges.size(); ++i)
        ranges[i] = static_cast<std::uint16_t>(i % 5 == 0 ? 0 : 500 + i);
    const auto written = rotating_scan(geometry, "VLP-16", ranges);
    written->sensorLabel = "lidar";
    written->timestamp = stamp_to_mrpt(1'300'000'000'000'000'000);
    written->sensorPose = mrpt::poses::CPose3D(0.5, 0, 1.7, 0.1, 0, 0);
    mrpt::io::CMemoryStream stream;
    auto archive = mrpt::serialization::archiveFrom(stream);
    archive.WriteObject(*written);
    stream.Seek(0);
    const auto read = std::dynamic_pointer_cast<mrpt::obs::CObservation>(archive.ReadObject());
    ASSERT_TRUE(read);

    SpinningScan scan;
    SpinningScanReader reader;
    ASSERT_TRUE(reader.read(*read, scan));
    EXPECT_EQ(scan.label, "lidar");
    EXPECT_EQ(scan.stamp_ns, 1'300'000'000'000'000'000);
    EXPECT_NEAR((scan.T_base_lidar.translation_m - Eigen::Vector3d(0.5, 0, 1.7)).norm(), 0, 1e-12);
    EXPECT_EQ(scan.end_s, geometry.sweep_s);
    EXPECT_EQ(scan.points.size(), 16u * 90 * 4 / 5);
    expect_rings_of_their_own(scan, geometry.elevations_deg);
    std::size_t i = 0;
    for (int row = 0; row < 16; ++row)
        for (int k = 0; k < 90; ++k) {
            const auto range = ranges[static_cast<std::size_t>(row * 90 + k)];
            if (range == 0) continue;
            const double e = geometry.elevations_deg[static_cast<std::size_t>(row)] * M_PI / 180;
            const double a = geometry.azimuth_rad(k), r_m = 0.002 * range;
            const SpinningPoint& p = scan.points[i++];
            ASSERT_NEAR(p.x_m, r_m * std::cos(e) * std::cos(a), 1e-5);
            ASSERT_NEAR(p.y_m, r_m * std::cos(e) * std::sin(a), 1e-5);
            ASSERT_NEAR(p.z_m, r_m * std::sin(e), 1e-5);
            ASSERT_NEAR(p.time_s, 0.1 * k / 90, 1e-7);
        }
}

TEST(CloudRings, are_told_by_the_order_of_the_points) {
    const auto elevations_deg = table_of_beams(64)->elevations_deg;
    const auto points_m = stored_like_kitti(elevations_deg, 360);
    EXPECT_EQ(rings_in_order(points_m), 64u);
    SpinningScan scan;
    CloudReader().read(points_m, {}, scan);
    EXPECT_EQ(scan.points.size(), points_m.size());
    expect_rings_of_their_own(scan, elevations_deg);
    EXPECT_EQ(scan.begin_s, -0.05);
    EXPECT_NEAR(scan.points.front().time_s, -0.05, 0.001) << "looks back";
    EXPECT_NEAR(scan.points[scan.ring_begin[1] - 1].time_s, 0.05, 0.001) << "looks back again";
    for (const SpinningPoint& p : scan.points)
        ASSERT_NEAR(p.time_s, -0.1 * std::atan2(p.y_m, p.x_m) / (2 * M_PI), 1e-6) << "clockwise, ahead at 0";
}

TEST(CloudRings, are_told_by_elevation_in_any_order) {
    const auto elevations_deg = table_of_beams(32)->elevations_deg;
    auto points_m = stored_like_kitti(elevations_deg, 180);
    for (std::size_t i = 0; i < points_m.size(); ++i)
        std::swap(points_m[i], points_m[i * 7919 % points_m.size()]);
    EXPECT_EQ(rings_in_order(points_m), 0u);
    SpinningScan scan;
    CloudReader().read(points_m, {}, scan);
    expect_rings_of_their_own(scan, elevations_deg);
}

TEST(CloudRings, elevations_without_gaps_become_bands) {
    std::vector<Eigen::Vector3f> points_m;
    for (int i = 0; i < 5000; ++i) {
        const double a = i * 2.399, e = (i % 997) / 997.0 - 0.5;
        points_m.emplace_back(9 * std::cos(a), 9 * std::sin(a), 9 * e);
    }
    SpinningScan scan;
    CloudReader().read(points_m, {}, scan);
    EXPECT_EQ(scan.rings(), 64u);
    EXPECT_EQ(scan.points.size(), points_m.size());
    CloudReader().read({}, {}, scan);
    EXPECT_EQ(scan.points.size(), 0u);
}

TEST(SpinningScanReader, reads_clouds_and_refuses_what_it_does_not_know) {
    mrpt::obs::CObservationPointCloud cloud;
    cloud.timestamp = stamp_to_mrpt(1'300'000'000'000'000'000);
    auto points = mrpt::maps::CPointsMapXYZI::Create();
    for (const auto& p : stored_like_kitti(table_of_beams(64)->elevations_deg, 90))
        points->insertPoint(p.x(), p.y(), p.z());
    const std::size_t count = points->size();
    points->insertPoint(0, 0, 0);
    cloud.pointcloud = points;
    SpinningScan scan;
    SpinningScanReader reader;
    ASSERT_TRUE(reader.read(cloud, scan));
    EXPECT_EQ(scan.rings(), 64u);
    EXPECT_EQ(scan.points.size(), count) << "without the one at the origin";

    const RangeImageGeometry geometry = small_image(10);
    const auto image = rotating_scan(geometry, "VLP-16", std::vector<std::uint16_t>(160, 1000));
    image->timestamp = INVALID_TIMESTAMP;
    EXPECT_FALSE(reader.read(*image, scan)) << "no stamp";
    EXPECT_EQ(scan.rings(), 0u);
    image->timestamp = cloud.timestamp;
    EXPECT_TRUE(reader.read(*image, scan));
    image->lidarModel = "UNKNOWN_SCANNER";
    EXPECT_FALSE(reader.read(*image, scan));
    EXPECT_FALSE(reader.read(*rotating_scan(geometry, "VLP-16", std::vector<std::uint16_t>(160, 0)), scan))
        << "no return";
    cloud.pointcloud.reset();
    EXPECT_FALSE(reader.read(cloud, scan));
}

TEST(SpinningScanReader, packets_and_the_image_made_of_them_agree) {
    const std::string packets_file = std::string(samples) + "test_velodyne_VLP16.rawlog";
    if (!std::filesystem::exists(packets_file)) GTEST_SKIP() << packets_file << " is not there (mrpt-common)";
    SpinningScan packets, image;
    SpinningScanReader reader;
    ASSERT_TRUE(reader.read(*first_observation(packets_file), packets));
    ASSERT_TRUE(reader.read(*first_observation(std::string(samples) + "rot_scan_velodyne.rawlog"), image));
    expect_rings_of_their_own(packets, table_of_beams(16)->elevations_deg);
    EXPECT_NEAR(packets.end_s, 0.0995, 0.001);
    EXPECT_NEAR(image.end_s, 0.0995, 0.001);
    // MRPT's image has the first of the two firings of each block, rounds azimuths to columns, and knows
    // nothing of the lasers' own times.
    ASSERT_GT(packets.points.size(), 1.9 * double(image.points.size()));
    for (std::size_t ring = 0; ring < 16; ++ring)
        for (std::uint32_t i = image.ring_begin[ring]; i < image.ring_begin[ring + 1]; ++i) {
            const auto& b = image.points[i];
            bool found = false;
            for (std::uint32_t k = packets.ring_begin[ring]; k < packets.ring_begin[ring + 1] && !found;
                 ++k) {
                const auto& a = packets.points[k];
                found = std::hypot(a.x_m - b.x_m, a.y_m - b.y_m) < 0.01 * std::hypot(a.x_m, a.y_m) &&
                        std::abs(a.z_m - b.z_m) < 0.01 && std::abs(a.time_s - b.time_s) < 0.002;
            }
            ASSERT_TRUE(found) << ring << " " << i;
        }
}

TEST(SpinningScanReader, packets_of_a_turn_give_its_points_at_their_own_times) {
    for (const int beams : {16, 32}) {
        // About as many firings as a turn of a tenth of a second has.
        const int columns = beams == 16 ? 1800 : 2160;
        auto geometry = small_image(columns);
        geometry.elevations_deg = table_of_beams(beams)->elevations_deg;
        std::vector<std::uint16_t> ranges;
        for (int row = 0; row < beams; ++row)
            for (int k = 0; k < columns; ++k)
                ranges.push_back(static_cast<std::uint16_t>(5000 + 30 * row + k));
        const auto image = rotating_scan(geometry, table_of_beams(beams)->model, ranges);
        image->timestamp = mrpt::Clock::fromDouble(1.4e9);
        image->minRange = 1;
        image->maxRange = 100;
        SpinningScan of_packets, of_image;
        SpinningScanReader reader;
        std::vector<std::uint16_t> intensity;
        ASSERT_TRUE(reader.read(*test::packets_of(*image), of_packets, &intensity));
        ASSERT_TRUE(reader.read(*image, of_image));
        ASSERT_EQ(of_packets.ring_begin, of_image.ring_begin);
        // In the image all of a column is one moment; a laser is fired up to 53 us after the first of its
        // firing, and the lidar has turned by then.
        const double turned = 2 * M_PI * 10 * 53e-6;
        for (std::size_t i = 0; i < of_packets.points.size(); ++i) {
            const auto &a = of_packets.points[i], &b = of_image.points[i];
            ASSERT_NEAR(a.time_s, b.time_s + 26e-6, 35e-6);
            ASSERT_NEAR(std::hypot(a.x_m, a.y_m), std::hypot(b.x_m, b.y_m), 2e-3);
            ASSERT_NEAR(a.z_m, b.z_m, 2e-3);
            ASSERT_LT(std::hypot(a.x_m - b.x_m, a.y_m - b.y_m),
                      1.1 * turned * std::hypot(a.x_m, a.y_m) + 3e-3);
        }
        EXPECT_EQ(intensity, std::vector<std::uint16_t>(of_packets.points.size(), 100 * 257));
    }
}
