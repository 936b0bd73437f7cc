/// UTM, ECEF and local frames against GeographicLib, and against themselves.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "api/parameters.h"
#include "gnss/geo_reference.h"
#include "gnss/transverse_mercator.h"
#include "gnss/utm.h"
#include "support/random_places.h"
#include "support/run_program.h"

#ifdef LOOPLINE_HAS_GEOGRAPHICLIB
#include <GeographicLib/Geocentric.hpp>
#include <GeographicLib/LocalCartesian.hpp>
#include <GeographicLib/TransverseMercator.hpp>
#include <GeographicLib/TransverseMercatorExact.hpp>
#include <GeographicLib/UTMUPS.hpp>
#endif

using namespace loopline;
using namespace loopline::gnss;
using loopline::test::RandomPlaces;

namespace {

constexpr double um = 1e-6;

/// Way over ground between two places that are near each other.
double apart_m(const Geodetic& a, const Geodetic& b) {
    constexpr double m_per_deg = wgs84::a_m * rad_per_deg;
    const double east_m = wrapped_longitude_deg(a.longitude_deg - b.longitude_deg) *
                          std::cos(a.latitude_deg * rad_per_deg) * m_per_deg;
    return std::hypot(east_m, (a.latitude_deg - b.latitude_deg) * m_per_deg);
}

}  // namespace

#ifdef LOOPLINE_HAS_GEOGRAPHICLIB

TEST(Utm, is_geographiclibs_in_every_zone) {
    RandomPlaces places(1);
    double worst_m = 0, worst_back_m = 0, worst_angle_rad = 0, worst_scale = 0;
    for (int i = 0; i < 20000; ++i) {
        const Geodetic place = places.draw(-80, 84);
        int zone = 0;
        bool north = false;
        double x = 0, y = 0, convergence_deg = 0, scale = 0;
        GeographicLib::UTMUPS::Forward(place.latitude_deg, place.longitude_deg, zone, north, x, y,
                                       convergence_deg, scale);
        const auto utm = to_utm(place);
        ASSERT_TRUE(utm);
        ASSERT_EQ(utm->zone, zone) << place.latitude_deg << " " << place.longitude_deg;
        ASSERT_EQ(utm->north, north);
        worst_m = std::max(worst_m, std::hypot(utm->easting_m - x, utm->northing_m - y));
        worst_angle_rad =
            std::max(worst_angle_rad, std::abs(utm->convergence_rad - convergence_deg * rad_per_deg));
        worst_scale = std::max(worst_scale, std::abs(utm->scale - scale));
        worst_back_m = std::max(worst_back_m, apart_m(from_utm(*utm), place));
    }
    EXPECT_LT(worst_m, 0.02 * um);
    EXPECT_LT(worst_back_m, 0.02 * um);
    EXPECT_LT(worst_angle_rad, 1e-13);
    EXPECT_LT(worst_scale, 1e-14);
    RecordProperty("worst_nm", std::to_string(worst_m * 1e9));
    RecordProperty("worst_back_nm", std::to_string(worst_back_m * 1e9));
}

TEST(Utm, zones_are_geographiclibs_with_norway_and_svalbard) {
    for (double latitude = -80; latitude < 84; latitude += 0.5)
        for (double longitude = -200; longitude <= 400; longitude += 0.5)
            ASSERT_EQ(*utm_zone(latitude, longitude),
                      GeographicLib::UTMUPS::StandardZone(latitude, longitude, GeographicLib::UTMUPS::UTM))
                << latitude << " " << longitude;
    EXPECT_EQ(*utm_zone(60, 4), 32) << "Bergen";
    EXPECT_EQ(*utm_zone(78, 15), 33) << "Longyearbyen";
    EXPECT_FALSE(utm_zone(84, 10));
    EXPECT_FALSE(utm_zone(-80.1, 10));
    EXPECT_FALSE(utm_zone(std::nan(""), 10));
}

TEST(Utm, a_drive_over_an_edge_stays_on_its_grid) {
    RandomPlaces places(2);
    double worst_m = 0, worst_back_m = 0;
    for (int i = 0; i < 5000; ++i) {
        Geodetic place = places.draw(-80, 84);
        const int zone = 1 + i % 60;
        place.longitude_deg = wrapped_longitude_deg(6 * zone - 183 + places.between(-9, 9));
        const bool north = i % 2 == 0;
        double x = 0, y = 0;
        GeographicLib::TransverseMercator::UTM().Forward(6 * zone - 183, place.latitude_deg,
                                                         place.longitude_deg, x, y);
        x += 500e3;
        y += north ? 0 : 10000e3;
        const Utm utm = to_utm(place, zone, north);
        worst_m = std::max(worst_m, std::hypot(utm.easting_m - x, utm.northing_m - y));
        worst_back_m = std::max(worst_back_m, apart_m(from_utm(utm), place));
    }
    EXPECT_LT(worst_m, 0.02 * um);
    EXPECT_LT(worst_back_m, 0.02 * um);
}

TEST(TransverseMercator, is_the_exact_one_up_to_30_degrees_beside_its_meridian) {
    const auto exact = GeographicLib::TransverseMercatorExact(wgs84::a_m, wgs84::flattening, 1);
    RandomPlaces places(3);
    double worst_m = 0, worst_back_m = 0, worst_angle_rad = 0, worst_scale = 0;
    for (int i = 0; i < 5000; ++i) {
        const double latitude = places.between(-89.9, 89.9), longitude = places.between(-30, 30);
        double x = 0, y = 0, convergence_deg = 0, scale = 0;
        exact.Forward(0, latitude, longitude, x, y, convergence_deg, scale);
        const TransverseMercator grid = project(latitude, longitude);
        worst_m = std::max(worst_m, std::hypot(grid.east_m - x, grid.north_m - y));
        worst_angle_rad =
            std::max(worst_angle_rad, std::abs(grid.convergence_rad - convergence_deg * rad_per_deg));
        worst_scale = std::max(worst_scale, std::abs(grid.scale - scale));
        const auto back = unproject(grid.east_m, grid.north_m);
        worst_back_m = std::max(
            worst_back_m, apart_m({back.latitude_deg, back.longitude_deg, 0}, {latitude, longitude, 0}));
    }
    EXPECT_LT(worst_m, 0.03 * um);
    EXPECT_LT(worst_back_m, 0.03 * um);
    EXPECT_LT(worst_angle_rad, 1e-11) << "near the poles it turns as fast as the longitude";
    EXPECT_LT(worst_scale, 1e-12);
}

TEST(LocalFrame, is_geographiclibs) {
    RandomPlaces places(4);
    const auto& earth = GeographicLib::Geocentric::WGS84();
    double worst_ecef_m = 0, worst_enu_m = 0;
    for (int i = 0; i < 5000; ++i) {
        const Geodetic origin = places.draw(-90, 90);
        const Geodetic place{std::clamp(origin.latitude_deg + places.between(-1, 1), -90.0, 90.0),
                             origin.longitude_deg + places.between(-1, 1), places.between(-500, 20000)};
        double x = 0, y = 0, z = 0;
        earth.Forward(place.latitude_deg, place.longitude_deg, place.height_m, x, y, z);
        worst_ecef_m = std::max(worst_ecef_m, (p_ecef_m(place) - Eigen::Vector3d(x, y, z)).norm());
        const GeographicLib::LocalCartesian local(origin.latitude_deg, origin.longitude_deg, origin.height_m,
                                                  earth);
        local.Forward(place.latitude_deg, place.longitude_deg, place.height_m, x, y, z);
        worst_enu_m =
            std::max(worst_enu_m, (LocalFrame(origin).p_enu_m(place) - Eigen::Vector3d(x, y, z)).norm());
    }
    EXPECT_LT(worst_ecef_m, 0.01 * um);
    EXPECT_LT(worst_enu_m, 0.01 * um);
}

#else

TEST(Utm, is_geographiclibs_in_every_zone) {
    GTEST_SKIP() << "libgeographiclib-dev is missing";
}

#endif

TEST(Utm, knows_a_place_that_was_published) {
    // CN Tower, Toronto: 43 38' 33.24" N, 79 23' 13.7" W is 17T 630084 4833438.
    const auto utm = to_utm({43 + 38 / 60.0 + 33.24 / 3600, -(79 + 23 / 60.0 + 13.7 / 3600), 0});
    EXPECT_EQ(utm->zone, 17);
    EXPECT_NEAR(utm->easting_m, 630084, 1);
    EXPECT_NEAR(utm->northing_m, 4833438, 1);
    const auto south = to_utm({-33.8568, 151.2153, 0});
    EXPECT_FALSE(south->north);
    EXPECT_GT(south->northing_m, 6e6) << "counts from 10 000 km";
    EXPECT_NEAR(apart_m(from_utm(*south), {-33.8568, 151.2153, 0}), 0, um);
}

TEST(LocalFrame, leads_back_to_where_it_came_from) {
    RandomPlaces places(5);
    double worst_m = 0, worst_ecef_m = 0;
    for (int i = 0; i < 20000; ++i) {
        const LocalFrame frame(places.draw(-90, 90));
        const double far_m = std::pow(10, places.between(0, 6));
        const Eigen::Vector3d p(places.between(-far_m, far_m), places.between(-far_m, far_m),
                                places.between(-100, 1000));
        worst_m = std::max(worst_m, (frame.p_enu_m(frame.geodetic(p)) - p).norm());
        const Eigen::Vector3d q = p_ecef_m(
            {places.between(-90, 90), places.between(-180, 180), std::pow(10, places.between(0, 7.4))});
        worst_ecef_m = std::max(worst_ecef_m, (p_ecef_m(geodetic_from_ecef(q)) - q).norm());
    }
    EXPECT_LT(worst_m, 0.02 * um);
    EXPECT_LT(worst_ecef_m, 0.05 * um) << "up to satellites";
    const Geodetic pole = geodetic_from_ecef({0, 0, wgs84::b_m + 5});
    EXPECT_NEAR(pole.latitude_deg, 90, 1e-12);
    EXPECT_NEAR(pole.height_m, 5, 1e-6);
}

TEST(LocalFrame, axes_point_east_north_and_up) {
    const LocalFrame frame({36.8, -4.4, 50});
    EXPECT_NEAR(frame.p_enu_m({36.8, -4.4, 60}).z(), 10, 1e-6);
    const Eigen::Vector3d east = frame.p_enu_m({36.8, -4.399, 50}), north = frame.p_enu_m({36.801, -4.4, 50});
    EXPECT_NEAR(east.x(), 89.2, 0.2);
    EXPECT_NEAR(east.y(), 0, 0.001);
    EXPECT_NEAR(north.y(), 111, 0.2);
    EXPECT_NEAR(north.x(), 0, 1e-6);
    // 1 km away the ellipsoid is 78 mm lower.
    const Geodetic far = frame.geodetic({1000, 0, 0});
    EXPECT_NEAR(far.height_m - 50, 0.0784, 0.001);
}

TEST(GeoReference, leads_from_one_frame_to_another_as_the_earth_does) {
    const GeoReference a({49.01, 8.41, 160}, 35), b({49.02, 8.43, 210}, -120);
    const Pose3 T_a_b = T_between(a, b);
    for (const Eigen::Vector3d& p_b_m : {Eigen::Vector3d(0, 0, 0), {500, -300, 20}, {-1e4, 2e4, 100}})
        EXPECT_LT((T_a_b * p_b_m - a.p_map_m(b.geodetic(p_b_m))).norm(), 1e-6);
}

TEST(GeoReference, a_map_is_turned_against_east) {
    const GeoReference reference({48.2, 16.37, 200}, 90);
    EXPECT_NEAR((reference.p_map_m(reference.geodetic({3, 4, 5})) - Eigen::Vector3d(3, 4, 5)).norm(), 0,
                0.02 * um);
    // x of the map points north.
    EXPECT_GT(reference.geodetic({100, 0, 0}).latitude_deg, 48.2008);
    EXPECT_NEAR(reference.geodetic({100, 0, 0}).longitude_deg, 16.37, 1e-9);
    EXPECT_LT(reference.geodetic({0, 100, 0}).longitude_deg, 16.369) << "y points west";
}

TEST(GeoReference, a_file_reads_back_to_the_same_bits) {
    test::TemporaryFolder folder;
    RandomPlaces places(6);
    for (int i = 0; i < 100; ++i) {
        const GeoReference written(places.draw(-90, 90), places.between(-180, 180));
        const std::string file = (folder / "map.georeference").string();
        write_georeference(file, written);
        const GeoReference read = read_georeference(file);
        ASSERT_EQ(read.origin().latitude_deg, written.origin().latitude_deg);
        ASSERT_EQ(read.origin().longitude_deg, written.origin().longitude_deg);
        ASSERT_EQ(read.origin().height_m, written.origin().height_m);
        ASSERT_EQ(read.heading_deg(), written.heading_deg());
    }
    const auto text = georeference_text(GeoReference({49.01, 8.4, 110.25}, 30));
    EXPECT_NE(text.find("latitude_deg = 49.01\nlongitude_deg = 8.4\nheight_m = 110.25\nheading_deg = 30\n"),
              std::string::npos)
        << text;
    EXPECT_NE(text.find("\nutm_epsg = 32632\nutm_zone = 32\n"), std::string::npos) << text;
    EXPECT_EQ(georeference_text(GeoReference({84.5, 8.4, 0}, 0)).find("utm"), std::string::npos)
        << "has no UTM";
}

TEST(GeoReference, what_is_wrong_in_a_file_is_said) {
    const auto sentence = [](const std::string& text) -> std::string {
        try {
            georeference_from_text(text, "g.txt");
        } catch (const std::runtime_error& e) {
            return e.what();
        }
        return "";
    };
    const std::string good = "latitude_deg = 1\nlongitude_deg = 2\nheight_m = 3\n";
    EXPECT_EQ(sentence(good), "");
    EXPECT_EQ(sentence("# x\n\nlatitude_deg = 1\nheight_m = 3\n"), "g.txt has no longitude_deg; add it");
    EXPECT_EQ(sentence(good + "hello\n"), "g.txt:4 is no line of a georeference; write key = value");
    EXPECT_EQ(sentence(good + "height_m = x\n"), "g.txt:4: height_m is not a number; correct it");
    EXPECT_EQ(sentence(good + "height_m = 4\n"),
              "g.txt:4 says height_m a second time; remove one of the two");
    EXPECT_EQ(sentence(good + "zone = 4\n"),
              "g.txt has the key zone, which a georeference does not know; remove it");
    EXPECT_EQ(sentence("latitude_deg = 91\nlongitude_deg = 2\nheight_m = 3\n"),
              "g.txt has a latitude_deg beyond 90; correct it");
    EXPECT_THROW(read_georeference("/nowhere/g.txt"), std::runtime_error);
    EXPECT_THROW(write_georeference("/nowhere/g.txt", {}), std::runtime_error);
}
