/// loopline import nmea as a user runs it.
#include <gtest/gtest.h>
#include <mrpt/obs/CObservationGPS.h>

#include <cmath>
#include <sstream>

#include "gnss/gps_observation.h"
#include "pipeline/log_source.h"
#include "support/run_program.h"

using namespace loopline;
using namespace loopline::test;

namespace {

std::string line_of(const std::string& body) {
    unsigned sum = 0;
    for (const char c : body) sum ^= static_cast<unsigned char>(c);
    char text[8];
    std::snprintf(text, sizeof text, "*%02X\r\n", sum);
    return "$" + body + text;
}

/// 23:59:59.0 to 00:00:00.8 at 5 Hz, with the date once a second and some lines that are not good.
std::string nmea_log() {
    std::string text = "a logger's greeting\r\n";
    for (int i = 0; i < 10; ++i) {
        const std::string time = (i < 5 ? "235959." : "000000.") + std::to_string(i % 5 * 2) + "00";
        const std::string place = ",4900.66" + std::to_string(i) + ",N,00824.000,E,";
        text += line_of("GPGGA," + time + place + "4,14,0.7,68.50,M,48.0,M,1.0,0001");
        if (i % 5 == 0)
            text += line_of("GPRMC," + time + ",A" + place + "10.0,090.0," + (i < 5 ? "310524" : "010624") +
                            ",,,R");
        text += line_of("GPGST," + time + ",1.0,0.02,0.01,10.0,0.02,0.01,0.03");
        text += line_of("GPGLL,4900.66,N,00824.000,E,235959,A");
    }
    return text + "$GPGGA,000001.000,4900.660,N,00824.000,E,4,14,0.7,68.50,M,48.0,M,1.0,0001*00\n$GPGGA,0000";
}

class ImportNmea : public ::testing::Test {
 protected:
    ProgramResult import(const std::string& text, const std::vector<std::string>& more = {}) {
        std::vector<std::string> words{"import", "nmea", folder.write("in.txt", text), "--out", out};
        words.insert(words.end(), more.begin(), more.end());
        return run_loopline(words);
    }
    TemporaryFolder folder;
    const std::string out = (folder / "out.rawlog").string();
};

}  // namespace

TEST_F(ImportNmea, fixes_have_the_receivers_time_over_midnight) {
    const auto result = import(nmea_log(), {"--antenna-x-m", "0.5", "--antenna-z-m", "1.8"});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    EXPECT_NE(result.out.find("10 fixes, 10 of them with a measured position, over 1.8 s; 10 GLL sentences "
                              "skipped"),
              std::string::npos)
        << result.out;
    for (const char* const said : {"1 line with no sentence left out", "1 line with no checksum left out",
                                   "1 line with a wrong checksum left out"})
        EXPECT_NE(result.err.find(said), std::string::npos) << result.err;

    LogSource source({out});
    StampNs expected_ns = *stamp_from_seconds_text("1717199999");
    int fixes = 0;
    for (StreamItem item; source.next(item); ++fixes, expected_ns += 200'000'000) {
        const auto observation =
            std::dynamic_pointer_cast<const mrpt::obs::CObservationGPS>(item.observation);
        ASSERT_TRUE(observation);
        EXPECT_EQ(observation->sensorLabel, "gnss");
        const auto fix = gnss::fix_from_mrpt(*observation, *stamp_from_mrpt(observation->timestamp));
        ASSERT_TRUE(fix);
        EXPECT_EQ(fix->stamp_ns, expected_ns);
        EXPECT_EQ(fix->quality, gnss::FixQuality::rtk_fixed);
        EXPECT_NEAR(fix->antenna.latitude_deg, 49 + (0.66 + 0.001 * fixes) / 60, 1e-9);
        EXPECT_EQ(fix->antenna.height_m, 116.5);
        EXPECT_FALSE(fix->received_ns) << "NMEA does not say";
        EXPECT_NEAR((*fix->sigma_enu_m - Eigen::Vector3d(0.01, 0.02, 0.03)).norm(), 0, 1e-8);
        EXPECT_EQ(fix->speed_mps.has_value(), fixes % 5 == 0);
        EXPECT_EQ(fix->p_base_antenna_m, Eigen::Vector3d(0.5, 0, 1.8));
    }
    EXPECT_EQ(fixes, 10);
    const std::string bytes = file_text(out);
    ASSERT_EQ(import(nmea_log(), {"--antenna-x-m", "0.5", "--antenna-z-m", "1.8"}).exit_code, 0);
    EXPECT_EQ(file_text(out), bytes);
}

TEST_F(ImportNmea, what_is_missing_is_said) {
    const std::string undated =
        line_of("GPGGA,120000,4900.660,N,00824.000,E,1,14,0.7,68.50,M,48.0,M,1.0,0001");
    auto result = import(undated);
    EXPECT_EQ(result.exit_code, 3);
    EXPECT_NE(result.err.find("no RMC or ZDA sentence says the date; give that of the first fix with --date"),
              std::string::npos)
        << result.err;
    EXPECT_FALSE(std::filesystem::exists(out));
    EXPECT_EQ(import(undated, {"--date", "2024-02-29"}).exit_code, 0);
    result = import(undated, {"--date", "2023-02-29"});
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_NE(result.err.find("date is no day such as 2024-05-31"), std::string::npos) << result.err;
    EXPECT_EQ(import("hello\n").exit_code, 3);
    EXPECT_EQ(import("").exit_code, 3);
}

TEST_F(ImportNmea, mrpts_own_program_reads_the_fixes) {
    if (run_program({"which", "rawlog-edit"}).exit_code != 0)
        GTEST_SKIP() << "rawlog-edit is not installed (package mrpt-apps)";
    ASSERT_EQ(import(nmea_log()).exit_code, 0);
    // It writes beside a log only if that is in its working directory.
    const auto result = run_program(
        {"sh", "-c", "cd " + folder.path().string() + " && rawlog-edit --export-gps-txt -i out.rawlog -w"});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    std::istringstream lines(file_text(folder / "out_gnss.txt"));
    std::size_t fixes = 0;
    for (std::string line; std::getline(lines, line);) {
        if (line.empty() || line[0] == '%') continue;
        std::istringstream columns(line);
        double time_s = 0, latitude_rad = 0, longitude_rad = 0, altitude_m = 0;
        int kind = 0, satellites = 0;
        columns >> time_s >> latitude_rad >> longitude_rad >> altitude_m >> kind >> satellites;
        EXPECT_NEAR(time_s, 1717199999 + 0.2 * static_cast<double>(fixes), 1e-3);
        EXPECT_NEAR(latitude_rad * 180 / M_PI, 49 + (0.66 + 0.001 * static_cast<double>(fixes)) / 60, 1e-9);
        EXPECT_NEAR(longitude_rad * 180 / M_PI, 8.4, 1e-9);
        EXPECT_NEAR(altitude_m, 68.5, 1e-6) << "above the geoid";
        EXPECT_EQ(kind, 4);
        EXPECT_EQ(satellites, 14);
        ++fixes;
    }
    EXPECT_EQ(fixes, 10u);
}
