/// Line observations: recorded and read back, hostile files, and the module that makes them.
#include <gtest/gtest.h>
#include <mrpt/io/CFileGZInputStream.h>
#include <mrpt/io/CFileGZOutputStream.h>
#include <mrpt/io/CMemoryStream.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/serialization/CArchive.h>

#include <filesystem>
#include <limits>
#include <random>
#include <sstream>

#include "lines/line_extraction.h"
#include "lines/observation_lines.h"
#include "property/lines_world.h"

using namespace loopline;
using mrpt::serialization::archiveFrom;

namespace {

class Collector : public Publisher {
 public:
    void publish(const mrpt::obs::CObservation::Ptr& o) override { observations.push_back(o); }
    void publish(const mrpt::obs::CObservation::Ptr& o, std::uint64_t) override { observations.push_back(o); }
    std::vector<mrpt::obs::CObservation::Ptr> observations;
};

mrpt::obs::CObservation2DRangeScan::Ptr scan_of_a_room(int seed, const std::string& label) {
    std::mt19937_64 random(static_cast<std::uint64_t>(seed));
    auto sweep = lines_world::sweep(lines_world::random_world(random, 5, 1), {});
    lines_world::add_range_noise(sweep, 0.01, random);
    auto scan = mrpt::obs::CObservation2DRangeScan::Create();
    scan->aperture = static_cast<float>(M_PI);
    scan->maxRange = 80;
    scan->stdError = 0.01f;
    scan->sensorLabel = label;
    scan->timestamp = stamp_to_mrpt(1'137'834'225'000'000'000 + seed * 200'000'000LL);
    scan->sensorPose = mrpt::poses::CPose3D(0.2, 0, 0.4, 0.01, 0, 0);
    const std::vector<char> valid(sweep.scan.size(), 1);
    scan->loadFromVectors(sweep.scan.size(), sweep.scan.ranges_m.data(), valid.data());
    return scan;
}

std::vector<CObservationLines::Ptr> extract(LineExtraction& module, int scans, const std::string& label) {
    Collector collector;
    module.start({});
    for (int k = 0; k < scans; ++k) {
        const auto scan = scan_of_a_room(k, label);
        module.process({static_cast<std::uint64_t>(k), *stamp_from_mrpt(scan->timestamp), scan}, collector);
    }
    std::vector<CObservationLines::Ptr> found;
    for (const auto& o : collector.observations)
        found.push_back(std::dynamic_pointer_cast<CObservationLines>(o));
    return found;
}

void expect_equal(const CObservationLines& a, const CObservationLines& b) {
    EXPECT_EQ(a.timestamp, b.timestamp);
    EXPECT_EQ(a.sensorLabel, b.sensorLabel);
    EXPECT_EQ(a.scan_label, b.scan_label);
    EXPECT_EQ(a.scan_beams, b.scan_beams);
    EXPECT_LT((a.sensor_pose.asVectorVal() - b.sensor_pose.asVectorVal()).norm(), 1e-15);
    ASSERT_EQ(a.segments().size(), b.segments().size());
    for (std::size_t i = 0; i < a.segments().size(); ++i) {
        const auto &s = a.segments()[i], &t = b.segments()[i];
        EXPECT_EQ(s.rho_m, t.rho_m);
        EXPECT_EQ(s.alpha_rad, t.alpha_rad);
        EXPECT_EQ(s.covariance, t.covariance);
        EXPECT_EQ(s.start_m, t.start_m);
        EXPECT_EQ(s.end_m, t.end_m);
        EXPECT_EQ(s.rms_m, t.rms_m);
        EXPECT_EQ(s.first_beam, t.first_beam);
        EXPECT_EQ(s.last_beam, t.last_beam);
        EXPECT_EQ(s.beam_count, t.beam_count);
    }
}

}  // namespace

TEST(LineExtractionModule, publishes_the_lines_of_every_scan_with_its_stamp_and_pose) {
    LineExtraction module;
    module.parameters();
    const auto found = extract(module, 5, "front");
    ASSERT_EQ(found.size(), 5u);
    for (int k = 0; k < 5; ++k) {
        const auto& lines = *found[static_cast<std::size_t>(k)];
        EXPECT_EQ(lines.timestamp, scan_of_a_room(k, "")->timestamp);
        EXPECT_EQ(lines.sensorLabel, "lines_front");
        EXPECT_EQ(lines.scan_label, "front");
        EXPECT_EQ(lines.scan_beams, 181u);
        EXPECT_DOUBLE_EQ(lines.sensor_pose.x(), 0.2);
        EXPECT_GE(lines.segments().size(), 2u);
    }
    Results results;
    module.finish(results);
    EXPECT_EQ(std::get<std::int64_t>(results.metrics.at("lines_scans")), 5);
}

TEST(LineExtractionModule, takes_only_the_lasers_that_were_asked_for) {
    LineExtraction module;
    ParameterTable table = module.parameters();
    ASSERT_FALSE(table.find("sensors")->parse("rear, left"));
    EXPECT_TRUE(extract(module, 3, "front").empty());
    EXPECT_EQ(extract(module, 3, "left").size(), 3u);
}

TEST(LineExtractionModule, survives_scans_that_hold_nothing) {
    LineExtraction module;
    module.parameters();
    module.start({});
    Collector collector;
    const float nan = std::numeric_limits<float>::quiet_NaN();
    for (const std::vector<float>& ranges : {std::vector<float>{},
                                             {1},
                                             {1, 2},
                                             std::vector<float>(181, 0),
                                             std::vector<float>(181, nan),
                                             std::vector<float>(181, -1),
                                             std::vector<float>(181, std::numeric_limits<float>::infinity()),
                                             std::vector<float>(181, 3),
                                             std::vector<float>(181, 79.9999f),
                                             std::vector<float>(181, 1e-30f)}) {
        auto scan = mrpt::obs::CObservation2DRangeScan::Create();
        scan->aperture = static_cast<float>(M_PI);
        scan->maxRange = 80;
        const std::vector<char> valid(ranges.size(), 1);
        if (!ranges.empty()) scan->loadFromVectors(ranges.size(), ranges.data(), valid.data());
        module.process({0, 0, scan}, collector);
    }
    for (const auto& o : collector.observations)
        EXPECT_TRUE(std::dynamic_pointer_cast<CObservationLines>(o)->segments().empty());
    Results results;
    module.finish(results);
    EXPECT_EQ(std::get<std::int64_t>(results.metrics.at("lines_unusable_scans")), 2);
}

TEST(ObservationLines, recorded_once_they_replay_without_the_scans) {
    LineExtraction module;
    module.parameters();
    const auto recorded = extract(module, 8, "front");
    const auto path = std::filesystem::temp_directory_path() / "loopline_lines_test.rawlog";
    {
        mrpt::io::CFileGZOutputStream file(path.string());
        auto archive = archiveFrom(file);
        for (const auto& o : recorded) archive << *o;
    }
    mrpt::io::CFileGZInputStream file(path.string());
    auto archive = archiveFrom(file);
    for (const auto& original : recorded) {
        const auto read = std::dynamic_pointer_cast<CObservationLines>(archive.ReadObject());
        ASSERT_TRUE(read);
        expect_equal(*original, *read);
        std::ostringstream text;
        read->getDescriptionAsText(text);
        EXPECT_NE(text.str().find("alpha [deg]"), std::string::npos);
    }
    std::filesystem::remove(path);
}

TEST(ObservationLines, damaged_files_end_in_an_exception) {
    LineExtraction module;
    module.parameters();
    const auto original = extract(module, 1, "front").at(0);
    mrpt::io::CMemoryStream whole;
    archiveFrom(whole) << *original;
    const auto* bytes = static_cast<const std::uint8_t*>(whole.getRawBufferData());
    const std::vector<std::uint8_t> good(bytes, bytes + whole.getTotalBytesCount());

    std::mt19937_64 random(8);
    int refused = 0;
    for (int k = 0; k < 3000; ++k) {
        std::vector<std::uint8_t> bad = good;
        const auto at = std::uniform_int_distribution<std::size_t>(40, bad.size() - 5)(random);
        if (k % 3 == 0) {
            bad.resize(at);
        } else if (k % 3 == 1) {
            bad[at] = static_cast<std::uint8_t>(random());
        } else {
            std::fill_n(bad.begin() + static_cast<std::ptrdiff_t>(at), 4, std::uint8_t{0xff});
        }
        mrpt::io::CMemoryStream stream;
        stream.Write(bad.data(), bad.size());
        stream.Seek(0);
        auto archive = archiveFrom(stream);
        try {
            const auto lines = std::dynamic_pointer_cast<CObservationLines>(archive.ReadObject());
            if (!lines) continue;
            for (const auto& s : lines->segments()) {
                EXPECT_TRUE(std::isfinite(s.rho_m) && s.covariance.allFinite());
            }
        } catch (const std::exception&) {
            ++refused;
        }
    }
    EXPECT_GT(refused, 1000) << "every truncated file at least";
}
