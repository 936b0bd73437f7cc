/// Clouds as PLY, PCD and LAS, read by small parsers of the test's own.
#include <cstring>
#include <random>

#include "output/las_format.h"
#include "output/stored_cloud_files.h"
#include "output_test_support.h"
#include "support/points_in.h"

using namespace loopline;
using namespace output_test;

namespace {

StoredCloud random_cloud(double extent_m, bool has_intensity) {
    std::mt19937_64 random(11);
    std::uniform_real_distribution<double> place(-extent_m, extent_m);
    StoredCloud cloud;
    cloud.first_ns = 1'316'999'999'950'000'000;  // 2011-09-26
    cloud.has_intensity = has_intensity;
    for (int i = 0; i < 3000; ++i) {
        CloudPoint point;
        for (auto& x : point.place) x = static_cast<std::int32_t>(place(random) * 1e4);
        point.time_ticks = static_cast<std::uint32_t>(37 * i);
        point.intensity = has_intensity ? static_cast<std::uint16_t>(21 * i) : std::uint16_t{0};
        cloud.push_back(point);
    }
    return cloud;
}

template <class T>
T take(const std::string& bytes, std::size_t& at) {
    T value;
    std::memcpy(&value, bytes.data() + at, sizeof value);
    at += sizeof value;
    return value;
}

/// Rows behind the line `last`, with coordinates of type Real.
template <class Real>
void expect_rows(const std::string& bytes, const std::string& last, const StoredCloud& cloud) {
    std::size_t at = bytes.find(last);
    ASSERT_NE(at, std::string::npos);
    at += last.size();
    for (const CloudPoint& point : cloud.points()) {
        for (const std::int32_t x : point.place)
            ASSERT_EQ(take<Real>(bytes, at), static_cast<Real>(x * 1e-4));
        if (cloud.has_intensity) {
            const float intensity = take<float>(bytes, at);
            ASSERT_EQ(std::lround(intensity * 65535), point.intensity);
        }
        ASSERT_EQ(take<float>(bytes, at), static_cast<float>(point.time_ticks * 1e-4));
    }
    EXPECT_EQ(at, bytes.size());
}

}  // namespace

TEST(StoredCloudFiles, ply_and_pcd_hold_every_number_as_float_near_the_origin_and_as_double_far_from_it) {
    const Folder folder;
    for (const double extent_m : {300.0, 20000.0})
        for (const bool has_intensity : {true, false}) {
            const StoredCloud cloud = random_cloud(extent_m, has_intensity);
            write_ply(folder / "a.ply", cloud);
            write_pcd(folder / "a.pcd", cloud);
            const std::string ply = content(folder / "a.ply"), pcd = content(folder / "a.pcd");
            EXPECT_NE(ply.find("element vertex 3000\n"), std::string::npos);
            EXPECT_NE(ply.find("UTC 1316999999.950000000\n"), std::string::npos);
            EXPECT_EQ(ply.find("intensity") != std::string::npos, has_intensity);
            if (extent_m < 4096) {
                expect_rows<float>(ply, "end_header\n", cloud);
                expect_rows<float>(pcd, "DATA binary\n", cloud);
            } else {
                EXPECT_NE(ply.find("property double x\n"), std::string::npos);
                expect_rows<double>(ply, "end_header\n", cloud);
                expect_rows<double>(pcd, "DATA binary\n", cloud);
            }
            // What draws them reads them, too.
            const auto from_ply = test::points_in(folder / "a.ply"),
                       from_pcd = test::points_in(folder / "a.pcd");
            ASSERT_EQ(from_ply.size(), 3000u);
            ASSERT_EQ(from_pcd.size(), 3000u);
            for (std::size_t i = 0; i < 3000; ++i) {
                const Eigen::Vector3f p = cloud.points()[i].p_map_m().cast<float>();
                ASSERT_EQ(from_ply[i], p);
                ASSERT_EQ(from_pcd[i], p);
            }
        }
}

TEST(StoredCloudFiles, las_holds_whole_numbers_and_gps_time) {
    const Folder folder;
    const StoredCloud cloud = random_cloud(20000, true);
    write_las(folder / "a.las", cloud);
    const std::string las = content(folder / "a.las");
    ASSERT_EQ(las.size(), 227u + 28u * 3000u);
    EXPECT_EQ(las.substr(0, 4), "LASF");
    std::size_t at = 6;
    EXPECT_EQ(take<std::uint16_t>(las, at), 1);  // GPS time less 1e9
    at = 24;
    EXPECT_EQ(take<std::uint8_t>(las, at), 1);
    EXPECT_EQ(take<std::uint8_t>(las, at), 2);
    at = 90;
    EXPECT_EQ(take<std::uint16_t>(las, at), 269);  // of the year: September 26
    EXPECT_EQ(take<std::uint16_t>(las, at), 2011);
    EXPECT_EQ(take<std::uint16_t>(las, at), 227);
    EXPECT_EQ(take<std::uint32_t>(las, at), 227u);
    EXPECT_EQ(take<std::uint32_t>(las, at), 0u);
    EXPECT_EQ(take<std::uint8_t>(las, at), 1);
    EXPECT_EQ(take<std::uint16_t>(las, at), 28);
    EXPECT_EQ(take<std::uint32_t>(las, at), 3000u);
    EXPECT_EQ(take<std::uint32_t>(las, at), 3000u);
    at = 131;
    for (int axis = 0; axis < 3; ++axis) EXPECT_EQ(take<double>(las, at), 1e-4);
    for (int axis = 0; axis < 3; ++axis) EXPECT_EQ(take<double>(las, at), 0);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        std::int32_t low = INT32_MAX, high = INT32_MIN;
        for (const CloudPoint& point : cloud.points()) {
            low = std::min(low, point.place[axis]);
            high = std::max(high, point.place[axis]);
        }
        EXPECT_DOUBLE_EQ(take<double>(las, at), high * 1e-4);
        EXPECT_DOUBLE_EQ(take<double>(las, at), low * 1e-4);
    }
    ASSERT_EQ(at, 227u);
    for (const CloudPoint& point : cloud.points()) {
        for (const std::int32_t x : point.place) ASSERT_EQ(take<std::int32_t>(las, at), x);
        ASSERT_EQ(take<std::uint16_t>(las, at), point.intensity);
        ASSERT_EQ(take<std::uint8_t>(las, at), 9);  // return 1 of 1
        at += 5;
        // 2011: 15 s ahead of UTC; 315964800 s from 1970 to 1980-01-06.
        ASSERT_NEAR(take<double>(las, at), 1316999999.95 - 315964800 + 15 - 1e9 + point.time_s(), 1e-6);
    }
    EXPECT_EQ(gps_ahead_of_utc_s(1'483'228'799'000'000'000), 17);
    EXPECT_EQ(gps_ahead_of_utc_s(1'483'228'800'000'000'000), 18);
    EXPECT_EQ(gps_ahead_of_utc_s(315'964'800'000'000'000), 0);
}

TEST(StoredCloudFiles, of_a_cloud_without_points_are_whole_all_the_same) {
    const Folder folder;
    const StoredCloud cloud;
    write_ply(folder / "a.ply", cloud);
    write_las(folder / "a.las", cloud);
    EXPECT_TRUE(test::points_in(folder / "a.ply").empty());
    EXPECT_EQ(content(folder / "a.las").size(), 227u);
}
