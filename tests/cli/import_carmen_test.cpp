/// loopline import carmen as a user runs it: real logs against the rawlogs that were made of them by another
/// program, equal bytes, and every way of being wrong.
#include <gtest/gtest.h>
#include <mrpt/io/CFileGZInputStream.h>
#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CActionRobotMovement2D.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/serialization/CArchive.h>

#include "api/pose2.h"
#include "api/stamp.h"
#include "support/run_program.h"
#include "support/shared_data.h"

using namespace loopline;
using namespace loopline::test;

namespace {

struct ScanAndOdometry {
    StampNs stamp_ns;
    mrpt::obs::CObservation2DRangeScan scan;
    Pose2 T_odom_base;  ///< increments added up
};

std::vector<ScanAndOdometry> read_frames(const std::filesystem::path& rawlog) {
    std::vector<ScanAndOdometry> result;
    mrpt::io::CFileGZInputStream stream(rawlog.string());
    auto archive = mrpt::serialization::archiveFrom(stream);
    Pose2 T_odom_base;
    try {
        while (true) {
            const auto object = archive.ReadObject();
            if (const auto actions = std::dynamic_pointer_cast<mrpt::obs::CActionCollection>(object)) {
                const auto& step = actions->getActionByClass<mrpt::obs::CActionRobotMovement2D>()
                                       ->rawOdometryIncrementReading;
                T_odom_base = T_odom_base * Pose2{step.x(), step.y(), step.phi()};
            } else if (const auto frame = std::dynamic_pointer_cast<mrpt::obs::CSensoryFrame>(object)) {
                const auto scan = frame->getObservationByClass<mrpt::obs::CObservation2DRangeScan>();
                result.push_back({*stamp_from_mrpt(scan->timestamp), *scan, T_odom_base});
            }
        }
    } catch (const std::exception&) {  // the end
    }
    return result;
}

std::string good_log() {
    return "FLASER 180" + [] {
        std::string ranges;
        for (int i = 0; i < 180; ++i) ranges += " 2.5";
        return ranges;
    }() + " 0 0 0 0 0 0 5.5 host 5.5\n";
}

class ImportCarmen : public ::testing::Test {
 protected:
    ProgramResult import(const std::vector<std::string>& more, const std::string& input) {
        std::vector<std::string> words{"import", "carmen", input, "--out", out};
        words.insert(words.end(), more.begin(), more.end());
        return run_loopline(words);
    }
    TemporaryFolder folder;
    std::string out = (folder / "out.rawlog").string();
};

struct RealLog {
    const char *log, *rawlog, *aperture_deg, *max_range_m, *laser_x_m;
};
std::ostream& operator<<(std::ostream& out, const RealLog& real) {
    return out << real.log;
}

class ImportRealCarmen : public ImportCarmen, public ::testing::WithParamInterface<RealLog> {};

}  // namespace

TEST_P(ImportRealCarmen, stamps_ranges_and_odometry_equal_the_rawlog_beside_it) {
    const RealLog& real = GetParam();
    NEEDS_SHARED_DATA(real.log);
    NEEDS_SHARED_DATA(real.rawlog);
    const auto result = import({"--aperture-deg", real.aperture_deg, "--max-range-m", real.max_range_m,
                                "--laser-x-m", real.laser_x_m},
                               shared_data() / real.log);
    ASSERT_EQ(result.exit_code, 0) << result.err;
    EXPECT_EQ(result.err, "");
    const auto ours = read_frames(out), theirs = read_frames(shared_data() / real.rawlog);
    ASSERT_EQ(ours.size(), theirs.size());
    ASSERT_GT(ours.size(), 200u);
    const Pose2 T_ours_theirs = ours[0].T_odom_base * theirs[0].T_odom_base.inverse();
    std::size_t beams = 0, other_validity = 0;
    double worst_position_m = 0, worst_heading_rad = 0, worst_range_m = 0;
    for (std::size_t i = 0; i < ours.size(); ++i) {
        ASSERT_LE(std::abs(ours[i].stamp_ns - theirs[i].stamp_ns), 1000) << "scan " << i;
        const auto &a = ours[i].scan, &b = theirs[i].scan;
        ASSERT_EQ(a.getScanSize(), b.getScanSize());
        ASSERT_NEAR(a.sensorPose.distanceTo(b.sensorPose), 0, 1e-6);
        ASSERT_NEAR(a.aperture, b.aperture, 1e-3);
        for (std::size_t k = 0; k < a.getScanSize(); ++k) {
            worst_range_m =
                std::max(worst_range_m, std::abs(double{a.getScanRange(k)} - double{b.getScanRange(k)}));
            ++beams;
            // The other program took ranges from 99 % of the maximum on for no returns.
            other_validity += a.getScanRange(k) < 0.99F * a.maxRange &&
                              a.getScanRangeValidity(k) != b.getScanRangeValidity(k);
        }
        const Pose2 theirs_here = T_ours_theirs * theirs[i].T_odom_base;
        worst_position_m = std::max(worst_position_m,
                                    (ours[i].T_odom_base.translation() - theirs_here.translation()).norm());
        worst_heading_rad = std::max(worst_heading_rad,
                                     std::abs(wrap_to_pi(ours[i].T_odom_base.phi_rad - theirs_here.phi_rad)));
    }
    EXPECT_LT(worst_range_m, 1e-6);
    EXPECT_LT(worst_position_m, 1e-6);
    EXPECT_LT(worst_heading_rad, 1e-6);
    EXPECT_EQ(other_validity, 0u) << "of " << beams << " beams";
}

INSTANTIATE_TEST_SUITE_P(
    Logs, ImportRealCarmen,
    ::testing::Values(
        RealLog{"intel/intel_1of5.log", "intel/intel_1of5.sf.rawlog", "180", "81", "0"},
        RealLog{"intel/intel_part1_full_rate.log", "intel/intel_part1_full_rate.sf.rawlog", "180", "81", "0"},
        RealLog{"cmu_wean/wean1.log", "cmu_wean/wean1.sf.rawlog", "180", "81", "0"},
        RealLog{"cmu_wean/wean2.log", "cmu_wean/wean2.sf.rawlog", "180", "81", "0"},
        RealLog{"cmu_wean/wean3.log", "cmu_wean/wean3.sf.rawlog", "180", "81", "0"},
        RealLog{"edmonton/edmonton_1of2.log", "edmonton/edmonton_1of2.sf.rawlog", "180", "51", "0"},
        RealLog{"breezy_mines/exp1_carmen.log", "breezy_mines/exp1.sf.rawlog", "240", "4.1", "0.145"},
        RealLog{"brenner_lego/robot4_carmen.log", "brenner_lego/robot4.sf.rawlog", "231.7", "6", "0.03"}),
    [](const auto& parameter) {
        std::string name = std::filesystem::path(parameter.param.log).stem().string();
        return name;
    });

TEST_F(ImportCarmen, intel_keeps_the_files_order_and_the_logs_own_maximum_range) {
    NEEDS_SHARED_DATA("intel/intel_part1_full_rate.log");
    const auto result = import({}, shared_data() / "intel/intel_part1_full_rate.log");
    ASSERT_EQ(result.exit_code, 0) << result.err;
    EXPECT_NE(result.out.find("5505 FLASER scans of 180 beams over 180.0 degrees in 1088.6 s"),
              std::string::npos)
        << result.out;
    EXPECT_NE(result.out.find("the file's order is kept"), std::string::npos);
    const auto frames = read_frames(out);
    ASSERT_EQ(frames.size(), 5505u);
    double way_m = 0;
    for (std::size_t i = 1; i < frames.size(); ++i)
        way_m += (frames[i].T_odom_base.translation() - frames[i - 1].T_odom_base.translation()).norm();
    EXPECT_NEAR(way_m, 204.5, 0.5) << "in the order of the stamps it would be 265.5 m";
    EXPECT_FLOAT_EQ(frames[0].scan.maxRange, 81.83F);
    for (const auto& frame : frames)
        for (std::size_t k = 0; k < frame.scan.getScanSize(); ++k)
            ASSERT_EQ(frame.scan.getScanRangeValidity(k), frame.scan.getScanRange(k) < 81.8F);
}

TEST_F(ImportCarmen, the_same_input_gives_the_same_bytes) {
    const std::string log = folder.write("a.log", good_log() + good_log());
    ASSERT_EQ(import({}, log).exit_code, 0);
    const std::string first = file_text(out);
    ASSERT_EQ(import({}, log).exit_code, 0);
    EXPECT_EQ(file_text(out), first);
    EXPECT_GT(first.size(), 100u);
}

TEST_F(ImportCarmen, several_inputs_are_one_log_in_the_order_given) {
    const std::string a = folder.write("a.log", good_log()),
                      b = folder.write("b.log", good_log() + good_log());
    ASSERT_EQ(run_loopline({"import", "carmen", b, a, "--out", out}).exit_code, 0);
    EXPECT_EQ(read_frames(out).size(), 3u);
}

TEST_F(ImportCarmen, damaged_lines_are_named_and_the_rest_is_there) {
    const auto result = import({}, folder.write("a.log", good_log() + "FLASER 180 1 2\n" + good_log()));
    EXPECT_EQ(result.exit_code, 0);
    EXPECT_NE(result.err.find("a.log:2: this FLASER line ends before its range; it is left out"),
              std::string::npos)
        << result.err;
    EXPECT_EQ(read_frames(out).size(), 2u);
}

TEST_F(ImportCarmen, what_is_wrong_ends_with_its_exit_code_one_sentence_and_no_file) {
    const std::string good = folder.write("good.log", good_log());
    const std::string no_scan = folder.write("odom.log", "ODOM 0 0 0 0 0 0 1 h 1\n"),
                      empty = folder.write("empty.log", "");
    const std::string nowhere = (folder / "nowhere.log").string();
    const struct {
        std::vector<std::string> words;
        int exit_code;
        std::string said;
    } cases[] = {
        {{"import"}, 2, "import needs a format"},
        {{"import", "carmne", good, "--out", out},
         2,
         "there is no format \"carmne\" to import; did you mean \"carmen\"?"},
        {{"import", "carmen", good}, 2, "--out"},
        {{"import", "carmen", "--out", out}, 2, "IN"},
        {{"import", "carmen", nowhere, "--out", out}, 3, "nowhere.log"},
        {{"import", "carmen", folder.path().string(), "--out", out}, 3, "can't read"},
        {{"import", "carmen", empty, "--out", out}, 3, "empty.log"},
        {{"import", "carmen", no_scan, "--out", out}, 3, "there is no laser scan"},
        {{"import", "carmen", good, "--out", (folder / "no/such/folder.rawlog").string()}, 2, "can't write"},
        {{"import", "carmen", good, "--out", good}, 2, "is one of the inputs"},
        {{"import", "carmen", good, "--out", out, "--aperture-deg", "400"}, 2, "--aperture-deg"},
        {{"import", "carmen", good, "--out", out, "--format", "banana"}, 2, "--format"},
        {{"import", "carmen", good, "--out", out, "--apertur-deg", "180"}, 2, "--apertur-deg"},
    };
    for (const auto& c : cases) {
        const auto result = run_loopline(c.words);
        EXPECT_EQ(result.exit_code, c.exit_code) << c.said << '\n' << result.err;
        EXPECT_NE(result.err.find(c.said), std::string::npos)
            << "expected: " << c.said << "\nsaid: " << result.err;
        EXPECT_FALSE(std::filesystem::exists(out)) << c.said;
        EXPECT_FALSE(std::filesystem::exists(out + ".partial")) << c.said;
    }
    EXPECT_EQ(file_text(good), good_log()) << "an input is never overwritten";
}
