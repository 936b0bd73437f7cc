/// Paths and clouds on the Earth as files, read by a JSON parser, by GDAL, and byte by byte.
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

#include "gnss/utm_of_map.h"
#include "output/trajectory_geojson.h"
#include "output/trajectory_kml.h"
#include "output/utm_las.h"
#include "output_test_support.h"
#include "support/gdal.h"
#include "support/points_in.h"

using namespace loopline;
using output_test::content;
using output_test::Folder;

namespace {

constexpr StampNs earth_start_ns = 1'400'000'000'123'456'789;

/// There and back along the map's x axis, 7 m a second, rising.
Trajectory path_along_x(std::size_t poses) {
    Trajectory trajectory;
    Matrix6d covariance = Matrix6d::Zero();
    covariance.diagonal() << 0.04, 0.09, 0.16, 1e-6, 1e-6, 4e-4;
    for (std::size_t i = 0; i < poses; ++i) {
        const double x_m = 7.0 * static_cast<double>(2 * i < poses ? i : poses - i);
        trajectory.append(
            i, earth_start_ns + static_cast<StampNs>(i) * 1'000'000'000,
            Pose3({x_m, 0.5 * x_m, 0.1 * static_cast<double>(i)}, Eigen::Quaterniond::Identity()),
            covariance);
    }
    return trajectory;
}

nlohmann::json geojson_of(const std::filesystem::path& file) {
    const auto json = nlohmann::json::parse(content(file));
    EXPECT_EQ(json.at("type"), "FeatureCollection");
    return json;
}

std::vector<nlohmann::json> features_of(const nlohmann::json& json, const std::string& kind) {
    std::vector<nlohmann::json> features;
    for (const auto& feature : json.at("features"))
        if (feature.at("properties").at("kind") == kind) features.push_back(feature);
    return features;
}

template <class T>
T number_in(const std::string& bytes, std::size_t at) {
    T value;
    std::memcpy(&value, bytes.data() + at, sizeof value);
    return value;
}

StoredCloud cloud_about(double extent_m) {
    StoredCloud cloud;
    cloud.first_ns = earth_start_ns;
    cloud.has_intensity = true;
    for (int i = 0; i < 2000; ++i) {
        CloudPoint point;
        point.place = {static_cast<std::int32_t>(extent_m * 1e4 * std::sin(0.7 * i)),
                       static_cast<std::int32_t>(extent_m * 1e4 * std::cos(1.3 * i)),
                       static_cast<std::int32_t>(1e5 * std::sin(2.1 * i))};
        point.intensity = static_cast<std::uint16_t>(13 * i);
        point.time_ticks = static_cast<std::uint32_t>(100 * i);
        cloud.push_back(point);
    }
    return cloud;
}

/// A GeoTIFF of one pixel, with the keys that a LAS file has.
std::string tiff_with_keys(const std::string& directory, const std::string& ascii) {
    std::string tiff = "II*";
    const auto add16 = [&tiff](std::uint16_t x) { tiff.append(reinterpret_cast<const char*>(&x), 2); };
    const auto add32 = [&tiff](std::uint32_t x) { tiff.append(reinterpret_cast<const char*>(&x), 4); };
    const auto entry = [&](std::uint16_t tag, std::uint16_t type, std::size_t count, std::uint32_t value) {
        add16(tag), add16(type), add32(static_cast<std::uint32_t>(count)), add32(value);
    };
    constexpr std::uint16_t entries = 12;
    const std::uint32_t behind = 8 + 2 + 12 * entries + 4, scale_at = behind + 8, tie_at = scale_at + 24,
                        directory_at = tie_at + 48;
    tiff.push_back('\0');
    add32(8);
    add16(entries);
    entry(256, 3, 1, 1), entry(257, 3, 1, 1), entry(258, 3, 1, 8), entry(259, 3, 1, 1), entry(262, 3, 1, 1);
    entry(273, 4, 1, behind), entry(278, 3, 1, 1), entry(279, 4, 1, 1);
    entry(33550, 12, 3, scale_at), entry(33922, 12, 6, tie_at);
    entry(34735, 3, directory.size() / 2, directory_at);
    entry(34737, 2, ascii.size(), directory_at + static_cast<std::uint32_t>(directory.size()));
    add32(0);
    tiff.append(8, '\0');
    for (const double x : {1., 1., 0., 0., 0., 0., 5e5, 5e6, 0.})
        tiff.append(reinterpret_cast<const char*>(&x), 8);
    return tiff + directory + ascii;
}

}  // namespace

TEST(TrajectoryGeojson, has_every_vertex_with_its_stamp_and_what_is_unsure_about_it) {
    const Folder folder;
    const EarthFrame earth{-33.85, 151.21, 60.5, 90};  // x points north
    Trajectory trajectory = path_along_x(40);
    Pose3 revised = trajectory[3].T_map_base;
    revised.translation_m.x() += 5;
    trajectory.revise(3, revised, trajectory[3].covariance);
    SetAside<PlacedFix> list;
    list.push_back({earth_start_ns + 5, {1, 2, 3}, 0});
    list.push_back({earth_start_ns + 6, {50, 2, 3}, 5});
    list.push_back({earth_start_ns + 7, {2, 2, NAN}, 0});
    const PlacedFixes fixes{&list, {"used", "a", "b", "c", "d", "off_the_path"}};
    EXPECT_EQ(write_trajectory_geojson(folder / "t.geojson", trajectory, earth, fixes), 0u);
    const auto json = geojson_of(folder / "t.geojson");
    const gnss::GeoReference reference(earth);
    for (const std::string kind : {"trajectory", "trajectory_online"}) {
        const auto features = features_of(json, kind);
        ASSERT_EQ(features.size(), 1u);
        const auto& coordinates = features[0].at("geometry").at("coordinates");
        const auto& properties = features[0].at("properties");
        ASSERT_EQ(coordinates.size(), 40u);
        ASSERT_EQ(properties.at("stamps_s").size(), 40u);
        for (std::size_t i = 0; i < 40; ++i) {
            const auto place =
                reference.geodetic(kind == "trajectory" ? trajectory[i].T_map_base.translation_m
                                                        : trajectory.T_map_base_online(i).translation_m);
            EXPECT_EQ(coordinates[i].at(0).get<double>(), place.longitude_deg);
            EXPECT_EQ(coordinates[i].at(1).get<double>(), place.latitude_deg);
            EXPECT_EQ(coordinates[i].at(2).get<double>(), place.height_m);
        }
        if (kind == "trajectory_online") continue;
        // x points north: its standard deviation is that of north.
        EXPECT_NEAR(properties.at("sigma_north_m")[7].get<double>(), 0.2, 1e-12);
        EXPECT_NEAR(properties.at("sigma_east_m")[7].get<double>(), 0.3, 1e-12);
        EXPECT_NEAR(properties.at("sigma_up_m")[7].get<double>(), 0.4, 1e-12);
        EXPECT_NEAR(properties.at("sigma_heading_rad")[7].get<double>(), 0.02, 1e-12);
    }
    EXPECT_NE(content(folder / "t.geojson").find("1400000003.123456789"), std::string::npos) << "all digits";
    const auto fates = features_of(json, "fixes");
    ASSERT_EQ(fates.size(), 2u);
    EXPECT_EQ(fates[0].at("properties").at("fate"), "used");
    ASSERT_EQ(fates[0].at("geometry").at("coordinates").size(), 2u);
    EXPECT_EQ(fates[0].at("geometry").at("coordinates")[0].size(), 3u);
    EXPECT_EQ(fates[0].at("geometry").at("coordinates")[1].size(), 2u) << "has no height";
    EXPECT_EQ(fates[1].at("properties").at("fate"), "off_the_path");
    EXPECT_EQ(fates[1].at("geometry").at("coordinates")[0].at(0).get<double>(),
              reference.geodetic({50, 2, 3}).longitude_deg);
}

TEST(TrajectoryGeojson, is_cut_at_the_meridian_of_180_degrees) {
    const Folder folder;
    for (const double origin_deg : {179.9995, -180.0}) {
        const EarthFrame earth{-16.5, origin_deg, 20, 0};
        Trajectory trajectory = path_along_x(41);
        write_trajectory_geojson(folder / "t.geojson", trajectory, earth, {});
        const auto parts = features_of(geojson_of(folder / "t.geojson"), "trajectory");
        // 53 m to the meridian and 140 m to where it turns; the other begins on it and stays east.
        ASSERT_EQ(parts.size(), origin_deg > 0 ? 3u : 1u);
        std::size_t vertices = 0;
        for (std::size_t k = 0; k < parts.size(); ++k) {
            const auto& line = parts[k].at("geometry").at("coordinates");
            EXPECT_EQ(parts[k].at("geometry").at("type"), "LineString");
            EXPECT_EQ(parts[k].at("properties").at("part"), k + 1);
            EXPECT_EQ(parts[k].at("properties").at("parts"), parts.size());
            for (const char* name : {"stamps_s", "sigma_east_m", "sigma_heading_rad"})
                EXPECT_EQ(parts[k].at("properties").at(name).size(), line.size()) << name;
            vertices += line.size();
            for (std::size_t i = 1; i < line.size(); ++i)
                EXPECT_LT(std::abs(line[i].at(0).get<double>() - line[i - 1].at(0).get<double>()), 1e-3);
            if (k == 0) continue;
            const auto& before = parts[k - 1].at("geometry").at("coordinates").back();
            EXPECT_EQ(std::abs(before.at(0).get<double>()), 180);
            EXPECT_EQ(line[0].at(0).get<double>(), -before.at(0).get<double>());
            EXPECT_EQ(line[0].at(1), before.at(1));
            EXPECT_EQ(line[0].at(2), before.at(2));
            // Straight on: its neighbours and it lie on a line.
            const double south_deg = before.at(1).get<double>(), next_deg = line[1].at(1).get<double>(),
                         last_deg = parts[k - 1]
                                        .at("geometry")
                                        .at("coordinates")
                                        .at(parts[k - 1].at("geometry").at("coordinates").size() - 2)[1];
            EXPECT_GE(south_deg, std::min(last_deg, next_deg));
            EXPECT_LE(south_deg, std::max(last_deg, next_deg));
        }
        EXPECT_EQ(vertices, 41 + 2 * (parts.size() - 1));
    }
}

TEST(TrajectoryGeojson, of_odd_paths_is_valid) {
    const Folder folder;
    const EarthFrame earth{48, 11, 500, 0};
    EXPECT_EQ(write_trajectory_geojson(folder / "t.geojson", {}, earth, {}), 0u);
    EXPECT_TRUE(features_of(geojson_of(folder / "t.geojson"), "trajectory").empty());
    Trajectory trajectory = path_along_x(1);
    write_trajectory_geojson(folder / "t.geojson", trajectory, earth, {});
    auto features = features_of(geojson_of(folder / "t.geojson"), "trajectory");
    ASSERT_EQ(features.size(), 1u);
    EXPECT_EQ(features[0].at("geometry").at("type"), "Point") << "a line has two positions";
    EXPECT_EQ(features[0].at("geometry").at("coordinates").size(), 3u);
    // A pose that is not finite is left out, what is unsure about one that has no covariance is not known.
    trajectory.append(1, earth_start_ns + 10, Pose3({NAN, 0, 0}, Eigen::Quaterniond::Identity()), {});
    trajectory.append(2, earth_start_ns + 20, Pose3(Pose2{3, 0, 0}), Matrix6d(-Matrix6d::Identity()));
    EXPECT_EQ(write_trajectory_geojson(folder / "t.geojson", trajectory, earth, {}), 1u);
    features = features_of(geojson_of(folder / "t.geojson"), "trajectory");
    EXPECT_EQ(features[0].at("geometry").at("coordinates").size(), 2u);
    EXPECT_TRUE(features[0].at("properties").at("sigma_up_m")[1].is_null());
    EXPECT_EQ(write_trajectory_kml(folder / "t.kml", trajectory, earth), 1u);
    EXPECT_EQ(content(folder / "t.kml").find("nan"), std::string::npos);
}

TEST(TrajectoryKml, has_times_in_utc_to_the_nanosecond) {
    EXPECT_EQ(iso_time_text(1'400'000'000'000'000'001), "2014-05-13T16:53:20.000000001Z");
    EXPECT_EQ(iso_time_text(951'782'399'999'999'999), "2000-02-28T23:59:59.999999999Z");
    EXPECT_EQ(iso_time_text(951'782'400'000'000'000), "2000-02-29T00:00:00.000000000Z");
    EXPECT_EQ(iso_time_text(-1), "1969-12-31T23:59:59.999999999Z");
}

TEST(TrajectoryFiles, are_read_by_gdal) {
    SKIP_WITHOUT_GDAL();
    const Folder folder;
    EarthFrame earth{-16.5, 179.9995, 20, 0};
    const Trajectory trajectory = path_along_x(41);
    write_trajectory_geojson(folder / "t.geojson", trajectory, earth, {});
    write_trajectory_kml(folder / "ellipsoid.kml", trajectory, earth);
    earth.geoid_separation_m = 48.5;
    write_trajectory_kml(folder / "sea.kml", trajectory, earth);
    const auto expected = test::positions_by_gdal(folder / "t.geojson", "kind = 'trajectory'");
    ASSERT_EQ(expected.size(), 45u);  // cut twice
    const gnss::GeoReference reference(earth);
    const auto first = reference.geodetic(trajectory[0].T_map_base.translation_m);
    EXPECT_NEAR(expected[0][0], first.longitude_deg, 1e-12);
    EXPECT_NEAR(expected[0][1], first.latitude_deg, 1e-12);
    EXPECT_NEAR(expected[0][2], first.height_m, 1e-9);
    for (const auto& [file, lowered_m] : {std::pair("ellipsoid.kml", 0.0), std::pair("sea.kml", 48.5)})
        for (const std::string name : {"trajectory", "trajectory over time"}) {
            const auto found = test::positions_by_gdal(folder / file, "Name = '" + name + "'");
            ASSERT_EQ(found.size(), expected.size()) << file << " " << name;
            for (std::size_t i = 0; i < found.size(); ++i) {
                ASSERT_NEAR(found[i][0], expected[i][0], 1e-12);
                ASSERT_NEAR(found[i][1], expected[i][1], 1e-12);
                ASSERT_NEAR(found[i][2], expected[i][2] - lowered_m, 1e-9);
            }
        }
    const std::string summary = test::said_by({"ogrinfo", "-al", "-so", (folder / "t.geojson").string()});
    EXPECT_NE(summary.find("Extent: (-180.000000, -16."), std::string::npos) << summary;
    EXPECT_NE(summary.find("ID[\"EPSG\",4326]"), std::string::npos) << summary;
}

TEST(UtmLas, holds_the_grids_coordinates_of_every_point_and_its_system) {
    const Folder folder;
    for (const auto& earth : {EarthFrame{49.01, 8.41, 160, 35}, EarthFrame{-33.85, 151.21, -12, 0}}) {
        const StoredCloud cloud = cloud_about(3000);
        const gnss::GeoReference reference(earth);
        const auto grid = grid_of(reference);
        ASSERT_TRUE(grid);
        write_utm_las(folder / "a.las", points_on_map(cloud), reference, *grid);
        const std::string las = content(folder / "a.las");
        const auto begin = number_in<std::uint32_t>(las, 96);
        ASSERT_EQ(las.size(), begin + 28u * 2000u);
        EXPECT_EQ(number_in<std::uint32_t>(las, 100), 2u);
        double unit_m[3], offset_m[3], low_m[3], high_m[3];
        for (std::size_t axis = 0; axis < 3; ++axis) {
            unit_m[axis] = number_in<double>(las, 131 + 8 * axis);
            offset_m[axis] = number_in<double>(las, 155 + 8 * axis);
            low_m[axis] = INFINITY, high_m[axis] = -INFINITY;
            EXPECT_EQ(unit_m[axis], 1e-4);
        }
        EXPECT_EQ(offset_m[0], std::round(grid->easting_m));
        for (std::size_t i = 0; i < 2000; ++i) {
            const CloudPoint point = cloud.points()[i];
            const auto place = reference.geodetic(point.p_map_m());
            const auto utm = gnss::to_utm(place, grid->zone, grid->north);
            const double expected_m[3] = {utm.easting_m, utm.northing_m, place.height_m};
            const std::size_t at = begin + 28 * i;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const double x_m =
                    offset_m[axis] + unit_m[axis] * number_in<std::int32_t>(las, at + 4 * axis);
                ASSERT_NEAR(x_m, expected_m[axis], 0.51e-4);
                low_m[axis] = std::min(low_m[axis], x_m), high_m[axis] = std::max(high_m[axis], x_m);
            }
            ASSERT_EQ(number_in<std::uint16_t>(las, at + 12), point.intensity);
            // 16 s ahead of UTC in 2014.
            ASSERT_NEAR(number_in<double>(las, at + 20),
                        1400000000.123456789 - 315964800 + 16 - 1e9 + point.time_s(), 1e-6);
        }
        for (std::size_t axis = 0; axis < 3; ++axis) {
            EXPECT_NEAR(number_in<double>(las, 179 + 16 * axis), high_m[axis], 1e-8);
            EXPECT_NEAR(number_in<double>(las, 187 + 16 * axis), low_m[axis], 1e-8);
        }
        // The two records between header and points.
        EXPECT_EQ(las.substr(229, 15), "LASF_Projection");
        EXPECT_EQ(number_in<std::uint16_t>(las, 245), 34735);
        const auto directory_bytes = number_in<std::uint16_t>(las, 247);
        const std::string directory = las.substr(281, directory_bytes);
        const std::size_t second = 281 + directory_bytes;
        EXPECT_EQ(number_in<std::uint16_t>(las, second + 18), 34737);
        const auto ascii_bytes = number_in<std::uint16_t>(las, second + 20);
        EXPECT_EQ(second + 54 + ascii_bytes, begin);
        const std::string ascii = las.substr(second + 54, ascii_bytes);
        EXPECT_EQ(ascii.find("heights above the ellipsoid|") == std::string::npos, false) << ascii;
        // What draws clouds reads them, from the file's own origin.
        const auto points = test::points_in(folder / "a.las");
        ASSERT_EQ(points.size(), 2000u);
        EXPECT_NEAR(points[7].x(), number_in<std::int32_t>(las, begin + 28 * 7) * 1e-4, 1e-3);
        if (!test::has_gdal()) continue;
        const int epsg = earth.latitude_deg > 0 ? 32632 : 32756;
        const std::string tiff = (folder / "keys.tif").string();
        std::ofstream(tiff, std::ios::binary) << tiff_with_keys(directory, ascii);
        EXPECT_NE(test::said_by({"gdalsrsinfo", "-o", "epsg", tiff}).find("EPSG:" + std::to_string(epsg)),
                  std::string::npos);
        const auto place = reference.geodetic(cloud.points()[11].p_map_m());
        char longitude[32], latitude[32];
        std::snprintf(longitude, sizeof longitude, "%.15g", place.longitude_deg);
        std::snprintf(latitude, sizeof latitude, "%.15g", place.latitude_deg);
        const auto by_gdal =
            test::numbers_in(test::said_by({"gdaltransform", "-s_srs", "EPSG:4326", "-t_srs",
                                            "EPSG:" + std::to_string(epsg), "-coord", longitude, latitude}));
        ASSERT_GE(by_gdal.size(), 2u);
        for (std::size_t axis = 0; axis < 2; ++axis)
            EXPECT_NEAR(offset_m[axis] + 1e-4 * number_in<std::int32_t>(las, begin + 28 * 11 + 4 * axis),
                        by_gdal[axis], 1e-4);
    }
}

TEST(UtmLas, of_a_map_that_reaches_far_is_coarser_and_there_is_none_near_the_poles) {
    const Folder folder;
    const StoredCloud cloud = cloud_about(210e3);
    const gnss::GeoReference reference({60, 10.5, 0}, 0);
    write_utm_las(folder / "a.las", points_on_map(cloud), reference, *grid_of(reference));
    const std::string las = content(folder / "a.las");
    EXPECT_EQ(number_in<double>(las, 131), 1e-3);
    const auto begin = number_in<std::uint32_t>(las, 96);
    const auto utm = gnss::to_utm(reference.geodetic(cloud.points()[1].p_map_m()), 32, true);
    EXPECT_NEAR(number_in<double>(las, 155) + 1e-3 * number_in<std::int32_t>(las, begin + 28), utm.easting_m,
                0.51e-3);
    for (const double latitude_deg : {84.2, -80.1, 90.0})
        EXPECT_FALSE(grid_of(gnss::GeoReference({latitude_deg, 10, 0}, 0))) << latitude_deg;
    const StoredCloud none;
    write_utm_las(folder / "none.las", points_on_map(none), reference, *grid_of(reference));
    EXPECT_TRUE(test::points_in(folder / "none.las").empty());
}
