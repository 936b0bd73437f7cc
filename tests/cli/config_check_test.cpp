/// `loopline check`: what it says about logs, good, lacking and damaged.
#include <gtest/gtest.h>

#include "support/run_program.h"

using namespace loopline;

namespace {

const std::string telecom_log =
    "/usr/share/mrpt/datasets/2006-01ENE-21-SENA_Telecom Faculty_one_loop_only.rawlog";

class CheckTest : public testing::Test {
 protected:
    test::ProgramResult check(const std::string& log, const std::string& modules = "scale shift") {
        const auto ini = folder_.write("e.ini", "[run]\nmodules = " + modules + "\nmaps = paper_map\n");
        return test::run_loopline(
            {"check", ini, "--rawlog", log},
            {std::string("LOOPLINE_PLUGINS=") + test::fixture_folder() + "/good", "COLUMNS=100"});
    }
    static void expect(const test::ProgramResult& result, int exit_code,
                       const std::vector<std::string>& said) {
        EXPECT_EQ(result.exit_code, exit_code) << result.out << result.err;
        for (const auto& words : said)
            EXPECT_NE(result.out.find(words), std::string::npos) << "\"" << words << "\" is not in:\n"
                                                                 << result.out << result.err;
    }
    test::TemporaryFolder folder_;
};

}  // namespace

TEST_F(CheckTest, a_good_log_is_described_and_approved) {
    expect(check(telecom_log), 0,
           {"it runs scale and shift, and the maps paper_map", "2006-01-21 09:03:45 UTC, 59.075 s long",
            "CObservation2DRangeScan: 225, 3.79 Hz, 361 beams over 180 deg, from 0.000 s to 59.075 s",
            "CObservationOdometry \"odometry\": 225", "scale takes CObservation2DRangeScan (in the log)",
            "paper_map takes CObservation2DRangeScan (in the log)", "Verdict: good to run."});
}

TEST_F(CheckTest, pauses_are_pointed_out) {
    expect(check("/usr/share/mrpt/datasets/graphslam-engine-demos/action_observations_map/simul.rawlog"), 0,
           {"\"LASER_SIM\" pauses for 2.274 s, from 20.876 s on", "see above what to look at"});
}

TEST_F(CheckTest, a_log_without_what_a_module_needs_is_refused) {
    expect(check("/usr/share/mrpt/datasets/kf-slam_demo.rawlog"), 3,
           {"CObservationBearingRange", "scale needs CObservation2DRangeScan, which is not in the log",
            "Verdict: it can't run on this log."});
}

TEST_F(CheckTest, a_cut_log_is_reported_with_what_lies_before_the_cut) {
    const auto log = folder_.write("cut.rawlog", test::file_text(telecom_log).substr(0, 50000));
    expect(check(log), 3,
           {"cut.rawlog: ", "Wrong:", "CObservation2DRangeScan: 6", "Verdict: damaged; a run saves"});
}

TEST_F(CheckTest, empty_and_junk_logs_are_refused_in_words) {
    expect(check(folder_.write("empty.rawlog", "")), 3, {"empty.rawlog: ", "it can't run"});
    expect(check(folder_.write("junk.rawlog", std::string(5000, 'x'))), 3, {"junk.rawlog: ", "it can't run"});
}

TEST_F(CheckTest, damaged_bytes_never_end_it_by_a_signal) {
    const std::string whole = test::file_text(telecom_log);
    for (const std::size_t place : {200u, 3000u, 40000u, 90000u, 150000u}) {
        std::string bytes = whole;
        for (std::size_t i = 0; i < 4; ++i) bytes[place + i] = static_cast<char>(0xFF);
        const auto result = check(folder_.write("odd.rawlog", bytes));
        EXPECT_TRUE(result.exit_code == 0 || result.exit_code == 3) << place << ": " << result.exit_code;
        EXPECT_NE(result.out.find("Verdict: "), std::string::npos) << place;
    }
}
