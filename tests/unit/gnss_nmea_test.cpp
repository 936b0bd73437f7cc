/// NMEA 0183: what sentences say, moments and dates, and fixes through MRPT's observations.
#include <gtest/gtest.h>
#include <mrpt/io/CMemoryStream.h>
#include <mrpt/serialization/CArchive.h>

#include <sstream>

#include "gnss/gps_observation.h"
#include "gnss/nmea_log.h"

using namespace loopline;
using namespace loopline::gnss;

namespace {

std::string sentence(const std::string& body) {
    char text[8];
    std::snprintf(text, sizeof text, "*%02X", nmea_checksum(body));
    return "$" + body + text;
}

NmeaLog log_of(const std::vector<std::string>& bodies) {
    std::string text;
    for (const auto& body : bodies) text += sentence(body) + "\r\n";
    std::istringstream stream(text);
    return read_nmea(stream);
}

std::size_t refused(const NmeaLog& log, NmeaRefusal why) {
    return log.refused[static_cast<std::size_t>(why)];
}

StampNs utc(const std::string& seconds) {
    return *stamp_from_seconds_text(seconds);
}

}  // namespace

TEST(NmeaSentence, checksums_of_published_sentences_are_right) {
    NmeaSentence s;
    EXPECT_EQ(read_sentence("$GPGGA,123519,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,*47\r\n", s),
              NmeaRefusal::none);
    EXPECT_EQ(s.talker, "GP");
    EXPECT_EQ(s.type, "GGA");
    ASSERT_EQ(s.fields.size(), 14u);
    EXPECT_EQ(s.field(1), "4807.038");
    EXPECT_EQ(s.field(99), "");
    EXPECT_EQ(read_sentence("$GPRMC,123519,A,4807.038,N,01131.000,E,022.4,084.4,230394,003.1,W*6A", s),
              NmeaRefusal::none);
    EXPECT_EQ(
        read_sentence("12:00:01.2 > $GPRMC,123519,A,4807.038,N,01131.000,E,022.4,084.4,230394,003.1,W*6a", s),
        NmeaRefusal::none)
        << "a logger's own stamp before it, and small letters";
}

TEST(NmeaSentence, each_fault_has_its_reason) {
    NmeaSentence s;
    EXPECT_EQ(read_sentence("GPGGA,1*00", s), NmeaRefusal::no_sentence);
    EXPECT_EQ(read_sentence("", s), NmeaRefusal::no_sentence);
    EXPECT_EQ(read_sentence("$GPGGA,123519", s), NmeaRefusal::no_checksum);
    EXPECT_EQ(read_sentence("$GPGGA,123519*4", s), NmeaRefusal::no_checksum);
    EXPECT_EQ(read_sentence("$GPGGA,123519*4G", s), NmeaRefusal::no_checksum);
    EXPECT_EQ(read_sentence("$GPGGA,123519,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,*00", s),
              NmeaRefusal::wrong_checksum);
    EXPECT_EQ(read_sentence("$GPGGA,123519,4807.039,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,*47", s),
              NmeaRefusal::wrong_checksum);
    EXPECT_EQ(read_sentence(sentence("GPGG,1"), s), NmeaRefusal::odd_name);
    EXPECT_EQ(read_sentence(sentence("gpgga,1"), s), NmeaRefusal::odd_name);
    EXPECT_EQ(read_sentence(sentence("GPGGA,\x01"), s), NmeaRefusal::odd_characters);
    EXPECT_EQ(read_sentence(sentence("GPGGA," + std::string(300, '1')), s), NmeaRefusal::too_long);
    const std::string of_a_maker = sentence("PUBX,00");  // the fields point into it
    EXPECT_EQ(read_sentence(of_a_maker, s), NmeaRefusal::none);
    EXPECT_EQ(s.talker, "P");
    EXPECT_EQ(s.type, "UBX");
}

TEST(NmeaMessages, a_published_fix_says_what_it_says) {
    const auto log =
        log_of({"GPGGA,123519,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,",
                "GPRMC,123519,A,4807.038,N,01131.000,E,022.4,084.4,230394,003.1,W",
                "GPGST,123519,3.2,6.6,4.7,47.3,5.8,5.6,22.0",
                "GPGSA,A,3,19,28,14,18,27,22,31,39,,,,,1.7,1.0,1.3", "GPHDT,123.456,T", "GPGSV,1,1,00"});
    ASSERT_EQ(log.epochs.size(), 1u);
    EXPECT_EQ(log.sentences, 5u);
    EXPECT_EQ(log.not_used.at("GSV"), 1u);
    const auto stamps = stamps_of(log);
    ASSERT_TRUE(stamps);
    EXPECT_EQ((*stamps)[0], utc("764426119")) << "1994-03-23 12:35:19";
    const GnssFix fix = log.epochs[0].fix((*stamps)[0]);
    EXPECT_TRUE(fix.is_usable());
    EXPECT_EQ(fix.quality, FixQuality::single);
    EXPECT_DOUBLE_EQ(fix.antenna.latitude_deg, 48 + 7.038 / 60);
    EXPECT_DOUBLE_EQ(fix.antenna.longitude_deg, 11 + 31.0 / 60);
    EXPECT_DOUBLE_EQ(fix.antenna.height_m, 545.4 + 46.9) << "above the ellipsoid";
    EXPECT_EQ(fix.geoid_separation_m, 46.9);
    EXPECT_EQ(fix.satellites, 8);
    EXPECT_EQ(fix.hdop, 0.9);
    EXPECT_EQ(fix.vdop, 1.3);
    EXPECT_EQ(*fix.sigma_enu_m, Eigen::Vector3d(5.6, 5.8, 22));
    EXPECT_NEAR(*fix.speed_mps, 22.4 * 0.514444, 1e-4);
    EXPECT_NEAR(*fix.course_rad, (90 - 84.4) * M_PI / 180, 1e-12);
    EXPECT_NEAR(*fix.heading_rad, (90 - 123.456) * M_PI / 180, 1e-12);
}

TEST(NmeaMessages, south_west_negative_heights_and_empty_fields) {
    auto log = log_of({"GNGGA,001043.00,3356.00001,S,07031.9999999,W,5,12,0.57,-5.5,M,-20.5,M,1.0,0001",
                       "GNVTG,270.0,T,,M,1.000,N,1.852,K,D"});
    const GnssFix fix = log.epochs.at(0).fix(0);
    EXPECT_EQ(fix.quality, FixQuality::rtk_float);
    EXPECT_NEAR(fix.antenna.latitude_deg, -(33 + 56.00001 / 60), 1e-13);
    EXPECT_NEAR(fix.antenna.longitude_deg, -(70 + 31.9999999 / 60), 1e-13);
    EXPECT_EQ(fix.antenna.height_m, -26);
    EXPECT_NEAR(*fix.course_rad, M_PI, 1e-12);
    EXPECT_NEAR(*fix.speed_mps, 1852.0 / 3600, 1e-12);
    // A receiver that sees nothing.
    log = log_of({"GPGGA,001044,,,,,0,00,99.99,,,,,,", "GPRMC,001044,V,,,,,,,010120,,,N"});
    ASSERT_EQ(log.epochs.size(), 1u);
    EXPECT_FALSE(log.epochs[0].fix(0).is_usable());
    EXPECT_FALSE(log.epochs[0].fix(0).has_position);
    // RMC alone has no height.
    log = log_of({"GPRMC,001045,A,4807.038,N,01131.000,E,022.4,,010120,,,F"});
    EXPECT_TRUE(log.epochs[0].fix(0).is_usable());
    EXPECT_FALSE(log.epochs[0].fix(0).has_height);
    EXPECT_EQ(log.epochs[0].fix(0).quality, FixQuality::rtk_float);
}

TEST(NmeaMessages, impossible_values_are_refused) {
    const auto refusals = [](const std::string& body) {
        const auto log = log_of({body});
        EXPECT_TRUE(log.epochs.empty());
        return refused(log, NmeaRefusal::impossible_value) + 10 * refused(log, NmeaRefusal::missing_field);
    };
    EXPECT_EQ(refusals("GPGGA,246000,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,"), 1u);
    EXPECT_EQ(refusals("GPGGA,123561,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,"), 1u);
    EXPECT_EQ(refusals("GPGGA,12351x,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,"), 1u);
    EXPECT_EQ(refusals("GPGGA,123519,9007.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,"), 1u);
    EXPECT_EQ(refusals("GPGGA,123519,4867.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,"), 1u) << "67 minutes";
    EXPECT_EQ(refusals("GPGGA,123519,4807.038,X,01131.000,E,1,08,0.9,545.4,M,46.9,M,,"), 1u);
    EXPECT_EQ(refusals("GPGGA,123519,4807.038,N,01131.000,,1,08,0.9,545.4,M,46.9,M,,"), 1u);
    EXPECT_EQ(refusals("GPGGA,123519,nan,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,"), 1u);
    EXPECT_EQ(refusals("GPGGA,123519,4807.038,N,01131.000,E,1,08,-1,545.4,M,46.9,M,,"), 1u);
    EXPECT_EQ(refusals("GPGGA,123519,4807.038,N,01131.000,E,1,8.5,0.9,545.4,M,46.9,M,,"), 1u);
    EXPECT_EQ(refusals("GPGGA,123519,4807.038,N,01131.000,E,1,08"), 10u);
    EXPECT_EQ(refusals("GPRMC,123519,A,4807.038,N,01131.000,E,022.4,084.4,310299,003.1,W"), 1u)
        << "no such day";
    EXPECT_EQ(refusals("GPGST,123519,3.2,,,,,,"), 10u);
}

TEST(NmeaLog, goes_on_over_midnight_and_back_before_the_first_date) {
    // 5 Hz positions, dates once a second; the log begins before the first of them.
    std::vector<std::string> bodies;
    const auto gga = [&](const char* time) {
        bodies.push_back(std::string("GPGGA,") + time + ",4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,");
    };
    gga("235959.60");
    gga("235959.80");
    gga("000000.00");
    bodies.push_back("GPRMC,000000.00,A,4807.038,N,01131.000,E,022.4,084.4,010320,003.1,W");
    gga("000000.20");
    gga("235959.90");  // a day later, nearly
    gga("000000.10");
    const auto stamps = stamps_of(log_of(bodies));
    ASSERT_TRUE(stamps);
    const StampNs midnight = utc("1583020800");  // 2020-03-01, after a 29th of February
    const std::vector<StampNs> expected{
        midnight - 400'000'000, midnight - 200'000'000, midnight,
        midnight + 200'000'000, midnight - 100'000'000, midnight + 100'000'000};
    EXPECT_EQ(*stamps, expected) << "nearest to the epoch before";
    EXPECT_FALSE(stamps_of(log_of({bodies[0]})));
    EXPECT_EQ((*stamps_of(log_of({bodies[0], bodies[2]}), day_number(2020, 2, 29)))[1], midnight);
    EXPECT_EQ((*stamps_of(log_of({"GPZDA,235960.00,31,12,2016,00,00",
                                  "GPGGA,235960.00,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,"})))[0],
              utc("1483228800"))
        << "a leap second";
}

TEST(NmeaLog, days_are_counted_as_the_calendar_does) {
    EXPECT_EQ(*day_number(1970, 1, 1), 0);
    EXPECT_EQ(*day_number(2000, 3, 1), 11017);
    EXPECT_EQ(*day_number(2026, 12, 31), 20818);
    DayNumber expected = 0;
    for (int year = 1970; year <= 2100; ++year)
        for (int month = 1; month <= 12; ++month)
            for (int day = 1; day <= 31; ++day)
                if (const auto number = day_number(year, month, day)) {
                    ASSERT_EQ(*number, expected++);
                }
    EXPECT_EQ(expected, 47847) << "days of 131 years";
}

TEST(GpsObservation, a_fix_comes_back_as_it_went) {
    GnssFix fix;
    fix.stamp_ns = utc("1583020799.95");
    fix.received_ns = fix.stamp_ns + 120'000'000;
    fix.quality = FixQuality::rtk_fixed;
    fix.antenna = {-33.123456789012, 151.987654321098, 71.25};
    fix.has_position = fix.has_height = true;
    fix.geoid_separation_m = 22.5;
    fix.satellites = 17;
    fix.hdop = 0.75;
    fix.vdop = 1.25;
    fix.sigma_enu_m = Eigen::Vector3d(0.25, 0.5, 0.75);
    fix.speed_mps = 13.5;
    fix.course_rad = -2.5;
    fix.heading_rad = 3.0;
    fix.p_base_antenna_m = {0.5, -0.25, 1.75};
    for (const FixQuality quality :
         {FixQuality::rtk_fixed, FixQuality::rtk_float, FixQuality::single, FixQuality::differential}) {
        fix.quality = quality;
        // Through the bytes of a rawlog.
        mrpt::io::CMemoryStream bytes;
        auto archive = mrpt::serialization::archiveFrom(bytes);
        archive << *gps_observation(fix, "gnss");
        bytes.Seek(0);
        const auto read = std::dynamic_pointer_cast<mrpt::obs::CObservationGPS>(archive.ReadObject());
        ASSERT_TRUE(read);
        EXPECT_EQ(read->sensorLabel, "gnss");
        EXPECT_TRUE(read->has_GGA_datum());
        EXPECT_TRUE(read->has_RMC_datum());
        EXPECT_EQ(*stamp_from_mrpt(read->timestamp), fix.stamp_ns);
        const auto back = fix_from_mrpt(*read, fix.stamp_ns);
        ASSERT_TRUE(back);
        EXPECT_EQ(back->received_ns, fix.received_ns);
        EXPECT_EQ(back->quality, quality);
        EXPECT_EQ(back->antenna.latitude_deg, fix.antenna.latitude_deg);
        EXPECT_EQ(back->antenna.longitude_deg, fix.antenna.longitude_deg);
        EXPECT_EQ(back->antenna.height_m, fix.antenna.height_m);
        EXPECT_EQ(back->satellites, 17);
        EXPECT_EQ(back->hdop, 0.75);
        EXPECT_EQ(back->vdop, 1.25);
        EXPECT_EQ(*back->sigma_enu_m, *fix.sigma_enu_m);
        EXPECT_NEAR(*back->speed_mps, 13.5, 1e-12);
        EXPECT_NEAR(*back->course_rad, -2.5, 1e-12);
        EXPECT_NEAR(*back->heading_rad, 3.0, 1e-12);
        EXPECT_EQ(back->p_base_antenna_m, fix.p_base_antenna_m);
        const auto& gga = read->getMsgByClass<mrpt::obs::gnss::Message_NMEA_GGA>().fields;
        EXPECT_EQ(gga.altitude_meters, 71.25 - 22.5) << "above the geoid, as GGA has it";
        EXPECT_EQ(gga.UTCTime.hour, 23);
        EXPECT_NEAR(gga.UTCTime.sec, 59.95, 1e-9);
    }
}

TEST(GpsObservation, the_best_that_there_is_counts) {
    using namespace mrpt::obs::gnss;
    mrpt::obs::CObservationGPS observation;
    EXPECT_FALSE(fix_from_mrpt(observation, 0)) << "there is nothing in it";
    Message_NMEA_RMC rmc;
    rmc.fields.validity_char = 'A';
    rmc.fields.latitude_degrees = 10;
    rmc.fields.speed_knots = 2;
    observation.setMsg(rmc);
    EXPECT_TRUE(fix_from_mrpt(observation, 0)->is_usable());
    EXPECT_FALSE(fix_from_mrpt(observation, 0)->has_height);
    Message_NV_OEM6_BESTPOS best;
    best.fields.solution_stat = nv_oem6_solution_status::SOL_COMPUTED;
    best.fields.position_type = nv_oem6_position_type::NARROW_FLOAT;
    best.fields.lat = 20;
    best.fields.hgt = 30;
    best.fields.undulation = 2;
    observation.setMsg(best);
    EXPECT_EQ(fix_from_mrpt(observation, 0)->antenna.latitude_deg, 20);
    EXPECT_EQ(fix_from_mrpt(observation, 0)->antenna.height_m, 32);
    EXPECT_EQ(fix_from_mrpt(observation, 0)->quality, FixQuality::rtk_float);
    EXPECT_FALSE(fix_from_mrpt(observation, 0)->sigma_enu_m) << "zeros are no standard deviations";
    Message_NMEA_GGA gga;
    gga.fields.latitude_degrees = 40;
    observation.setMsg(gga);
    EXPECT_FALSE(fix_from_mrpt(observation, 0)->is_usable()) << "a receiver that has no fix";
    gga.fields.fix_quality = 4;
    observation.setMsg(gga);
    EXPECT_EQ(fix_from_mrpt(observation, 0)->antenna.latitude_deg, 40);
    EXPECT_FALSE(fix_from_mrpt(observation, 0)->hdop);
    for (const double latitude : {91.0, std::nan(""), HUGE_VAL}) {
        gga.fields.latitude_degrees = latitude;
        observation.setMsg(gga);
        EXPECT_FALSE(fix_from_mrpt(observation, 0));
    }
}

TEST(GnssAngles, east_and_compass_lead_back) {
    EXPECT_NEAR(east_angle_rad(0), M_PI / 2, 1e-15);
    EXPECT_NEAR(east_angle_rad(270), M_PI, 1e-15);
    EXPECT_NEAR(compass_deg(-M_PI / 2), 180, 1e-12);
    for (int degrees = 0; degrees < 360; ++degrees)
        EXPECT_NEAR(std::remainder(compass_deg(east_angle_rad(degrees)) - degrees, 360), 0, 1e-10);
}
