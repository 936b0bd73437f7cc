/// Tables and column maps that nobody meant to write: one sentence or a rawlog, never anything else, and
/// nothing that is not finite comes out.
#include <gtest/gtest.h>
#include <mrpt/obs/CObservationIMU.h>
#include <mrpt/obs/CObservationOdometry.h>

#include <cmath>
#include <random>

#include "importers/csv_importer.h"
#include "support/run_program.h"

using namespace loopline;

namespace {

const std::string good_map =
    "[clock]\nutc_from = gps\nlatency_s = 0.1\n[gps]\nkind = gnss\nfile = g.csv\ntime = t in ms\nutc = u in "
    "ms\nlatitude "
    "= lat in deg\nlongitude = lon in deg\nheight = h\n[car]\nkind = steering\nfile = c.csv\ntime = t\nspeed "
    "= v in "
    "km/h\nsteering = a in deg times -1\nwheel_base_m = 2.7\n[truth]\nkind = reference\nfile = c.csv\ntime = "
    "t\nx = v\ny = "
    "a\nyaw = a in deg\n";
const std::string good_fixes =
    "t,u,lat,lon,h\n1000,1600000000000,50,8,100\n1200,1600000000200,50.00001,8,\"100\"\n";
const std::string good_car = "# from a car\nt;v (km/h);a\n1;36;0\n1.1;36;-5\n1.2;37;1e1\n";

std::string changed(std::string text, std::mt19937& random) {
    static const std::string likely = ",;.-+eE0123456789\"[]()=# \t\r\n\0\xffnaif";
    for (std::size_t times = 1 + random() % 4; times > 0; --times) {
        const std::size_t at = random() % (text.size() + 1);
        const char c = likely[random() % likely.size()];
        if (const auto what = random() % 3; what == 0)
            text.insert(at, 1 + (random() % 30 == 0 ? 200 : 0), c);
        else if (what == 1)
            text.erase(at, 1 + random() % 6);
        else if (at < text.size())
            text[at] = c;
    }
    return text;
}

struct FiniteSink : RawlogSink {
    void write(const mrpt::serialization::CSerializable& object) override {
        ++written;
        if (const auto* car = dynamic_cast<const mrpt::obs::CObservationOdometry*>(&object)) {
            EXPECT_TRUE(std::isfinite(car->odometry.x() + car->odometry.y() + car->odometry.phi()));
            EXPECT_TRUE(std::isfinite(car->velocityLocal.vx + car->velocityLocal.omega));
        }
    }
    void true_pose(StampNs, const Pose3& T_map_base) override {
        EXPECT_TRUE(T_map_base.translation_m.allFinite() && T_map_base.rotation.coeffs().allFinite());
    }
    void warn(const std::string& sentence) override { EXPECT_FALSE(sentence.empty()); }
    int written = 0;
};

}  // namespace

TEST(HostileTables, give_a_sentence_or_observations) {
    std::mt19937 random(7);
    const test::TemporaryFolder folder;
    int imported = 0, refused = 0;
    for (int i = 0; i < 400; ++i) {
        const std::string run =
            std::to_string(i);  // a folder of its own: files that are cut and written again are slow
        const auto sometimes = [&](const std::string& text) {
            return random() % 2 == 0 ? text : changed(text, random);
        };
        folder.write(run + "/g.csv", sometimes(good_fixes));
        folder.write(run + "/c.csv", sometimes(good_car));
        CsvImporter importer;
        importer.parameters().find("columns")->parse(folder.write(run + "/map.ini", sometimes(good_map)));
        FiniteSink sink;
        try {
            importer.import({(folder / run).string()}, sink);
            EXPECT_GT(sink.written, 0);
            ++imported;
        } catch (const std::runtime_error& e) {
            EXPECT_NE(std::string(e.what()), "");
            ++refused;
        }
    }
    EXPECT_GT(imported, 80);
    EXPECT_GT(refused, 80);
}
