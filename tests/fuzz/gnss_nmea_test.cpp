/// Lines that a receiver never said: the reader neither fails nor believes what can't be.
#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <random>

#include "gnss/gps_observation.h"
#include "gnss/nmea_log.h"

using namespace loopline;
using namespace loopline::gnss;

namespace {

const char* const good_lines[] = {"GPGGA,123519.25,4807.038,N,01131.000,E,4,08,0.9,545.4,M,46.9,M,1.5,0012",
                                  "GNRMC,123519.25,A,4807.038,N,01131.000,E,022.4,084.4,230394,003.1,W,R",
                                  "GPGST,123519.25,3.2,6.6,4.7,47.3,5.8,5.6,22.0",
                                  "GPVTG,054.7,T,034.4,M,005.5,N,010.2,K",
                                  "GPGSA,A,3,04,05,,09,12,,,24,,,,,2.5,1.3,2.1",
                                  "GPHDT,274.07,T",
                                  "GPZDA,201530.00,04,07,2002,00,00"};

std::string with_checksum(const std::string& body) {
    char text[8];
    std::snprintf(text, sizeof text, "*%02X", nmea_checksum(body));
    return "$" + body + text;
}

class Mutator {
 public:
    explicit Mutator(unsigned seed) : engine_(seed) {}

    std::size_t below(std::size_t count) { return engine_() % count; }
    std::string mutated(std::string text) {
        for (std::size_t times = 1 + below(4); times > 0; --times) {
            static const std::string likely = ",.-+eE0123456789$*NSWEAVMTnaif\0\x80\xff ";
            const char c = below(4) > 0 ? likely[below(likely.size())] : static_cast<char>(below(256));
            const std::size_t at = below(text.size() + 1);
            switch (below(4)) {
                case 0:
                    text.insert(at, 1 + (below(20) == 0 ? below(300) : 0), c);
                    break;
                case 1:
                    if (!text.empty()) text.erase(at % text.size(), 1 + below(8));
                    break;
                case 2:
                    if (!text.empty()) text[at % text.size()] = c;
                    break;
                default:
                    text = text.substr(0, at) + text.substr(below(text.size() + 1));
            }
        }
        return text;
    }

 private:
    std::mt19937 engine_;
};

}  // namespace

TEST(HostileNmea, every_line_is_counted_once_and_no_fix_is_impossible) {
    Mutator mutator(1);
    NmeaReader reader;
    std::size_t lines = 0;
    for (int i = 0; i < 100000; ++i) {
        const std::string& body = good_lines[mutator.below(std::size(good_lines))];
        // Half with a checksum that is right, so that the fields are looked at.
        const std::string line = mutator.below(2) == 0 ? with_checksum(mutator.mutated(body))
                                                       : mutator.mutated(with_checksum(body));
        if (line.find_first_not_of(" \t\r\n") == std::string::npos) continue;
        ++lines;
        reader.read(line);
    }
    const NmeaLog log = reader.take();
    std::size_t counted = log.sentences;
    for (const std::size_t count : log.refused) counted += count;
    for (const auto& [type, count] : log.not_used) counted += count;
    EXPECT_LE(counted, lines);
    EXPECT_LE(log.not_used.size(), 100u);
    EXPECT_GT(log.sentences, 5000u) << "many a change does no harm";
    for (std::size_t i = 1; i < nmea_refusals; ++i)
        EXPECT_GT(log.refused[i], 0u) << name_of(static_cast<NmeaRefusal>(i));

    const auto stamps = stamps_of(log);
    ASSERT_TRUE(stamps);
    for (std::size_t i = 0; i < log.epochs.size(); ++i) {
        const GnssFix fix = log.epochs[i].fix((*stamps)[i]);
        ASSERT_TRUE(std::abs(fix.antenna.latitude_deg) <= 90 && std::abs(fix.antenna.longitude_deg) <= 180);
        ASSERT_TRUE(std::isfinite(fix.antenna.height_m));
        ASSERT_TRUE(!fix.sigma_enu_m || fix.sigma_enu_m->allFinite());
        const auto back = fix_from_mrpt(*gps_observation(fix, "gnss"), fix.stamp_ns);
        ASSERT_TRUE(back);
        ASSERT_EQ(back->is_usable(), fix.is_usable());
    }
}

TEST(HostileGps, whatever_bytes_its_messages_hold_a_fix_is_possible_or_none) {
    using namespace mrpt::obs::gnss;
    std::mt19937 engine(2);
    GnssFix good;
    good.stamp_ns = 1'400'000'000'000'000'000;
    good.quality = FixQuality::rtk_fixed;
    good.has_position = good.has_height = true;
    good.antenna = {49, 8, 120};
    good.sigma_enu_m = Eigen::Vector3d(0.01, 0.01, 0.02);
    good.vdop = 1;
    good.speed_mps = 3;
    good.course_rad = good.heading_rad = 1;
    const auto damage = [&engine](auto& fields) {
        unsigned char bytes[sizeof fields];
        std::memcpy(bytes, &fields, sizeof fields);
        for (unsigned times = engine() % 12; times > 0; --times)
            bytes[engine() % sizeof fields] = static_cast<unsigned char>(engine() % 3 == 0 ? 255 : engine());
        std::memcpy(&fields, bytes, sizeof fields);
    };
    std::size_t none = 0, usable = 0;
    for (int i = 0; i < 50000; ++i) {
        const auto observation = gps_observation(good, "gnss");
        damage(observation->getMsgByClass<Message_NMEA_GGA>().fields);
        damage(observation->getMsgByClass<Message_NMEA_RMC>().fields);
        damage(observation->getMsgByClass<Message_NMEA_GSA>().fields);
        damage(observation->getMsgByClass<Message_NV_OEM6_BESTPOS>().fields);
        damage(observation->getMsgByClass<Message_NV_OEM6_INSPVAS>().fields);
        if (engine() % 2 == 0) observation->messages.erase(NMEA_GGA);
        if (engine() % 4 == 0) observation->messages.erase(NV_OEM6_BESTPOS);
        const StampNs stamp_ns = engine() % 10 == 0 ? std::numeric_limits<StampNs>::max() : good.stamp_ns;
        const auto fix = fix_from_mrpt(*observation, stamp_ns);
        if (!fix) {
            ++none;
            continue;
        }
        usable += fix->is_usable();
        const auto is_within = [](double value, double most) { return std::abs(value) <= most; };
        ASSERT_TRUE(!fix->has_position ||
                    (is_within(fix->antenna.latitude_deg, 90) && is_within(fix->antenna.longitude_deg, 360)));
        ASSERT_TRUE(!fix->has_height || is_within(fix->antenna.height_m, 1e9));
        ASSERT_TRUE(!fix->sigma_enu_m || (fix->sigma_enu_m->array() > 0).all());
        ASSERT_TRUE(!fix->sigma_enu_m || fix->sigma_enu_m->allFinite());
        ASSERT_TRUE(is_within(fix->hdop.value_or(0), 1e39) && is_within(fix->vdop.value_or(0), 1e5));
        ASSERT_TRUE(is_within(fix->speed_mps.value_or(0), 1e4) && is_within(fix->course_rad.value_or(0), 4));
        ASSERT_TRUE(is_within(fix->heading_rad.value_or(0), 4));
        ASSERT_LE(std::abs(fix->utc_ns.value_or(stamp_ns) - stamp_ns), 43'201'000'000'000);
    }
    EXPECT_GT(none, 500u);
    EXPECT_GT(usable, 10000u);
}
