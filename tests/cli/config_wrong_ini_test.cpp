/// Every kind of wrong configuration, through the program: exit code 2, file:line, the nearest name, nothing
/// written.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "support/built_files.h"
#include "support/run_program.h"

using namespace loopline;

namespace {

struct WrongIni {
    std::string name;               ///< of the test
    std::string text;               ///< of e.ini; beside it lie a.rawlog and truth.tum
    std::vector<std::string> said;  ///< each must be in the complaint
    std::vector<std::string> arguments = {};
    int exit_code = 2;
};

const std::string run_section = "[run]\nrawlog = a.rawlog\nmodules = scale\n";  // lines 1 to 3

const std::vector<WrongIni> wrong_inis{
    {"unknown_section", run_section + "[outptus]\nmaps = false\n", {"e.ini:4: ", "[outptus]", "\"outputs\""}},
    {"unknown_module_section", run_section + "[sacle]\nrefine = true\n", {"e.ini:4: ", "\"scale\""}},
    {"unknown_key",
     run_section + "[scale]\nsigma_range_n = 0.1\n",
     {"e.ini:5: ", "sigma_range_n", "\"sigma_range_m\""}},
    {"unknown_host_key", run_section + "[outputs]\nsnapshot = no\n", {"e.ini:5: ", "\"snapshots\""}},
    {"key_of_another_section",
     run_section + "[scale]\noffset_m = 1\n",
     {"e.ini:5: ", "it is one of [shift]"}},
    {"no_number",
     run_section + "[scale]\nsigma_range_m = banana\n",
     {"e.ini:5: ", "is not a number: \"banana\""}},
    {"decimal_comma", run_section + "[scale]\nsigma_range_m = 0,5\n", {"e.ini:5: ", "is not a number"}},
    {"unit_in_value", run_section + "[scale]\nsigma_range_m = 0.5 m\n", {"e.ini:5: ", "is not a number"}},
    {"not_a_whole_number", run_section + "[scale]\nwindow_scans = 2.5\n", {"e.ini:5: ", "whole number"}},
    {"above_range", run_section + "[scale]\ngate_deg = 400\n", {"e.ini:5: ", "out of range", "0 .. 90"}},
    {"below_range", run_section + "[scale]\nwindow_scans = 0\n", {"e.ini:5: ", "out of range", ">= 1"}},
    {"not_finite", run_section + "[scale]\nsigma_range_m = nan\n", {"e.ini:5: ", "is not a number"}},
    {"bad_choice",
     run_section + "[scale]\nmethod = carefull\n",
     {"e.ini:5: ", "plain | careful", "\"careful\"?"}},
    {"bad_switch", run_section + "[scale]\nrefine = maybe\n", {"e.ini:5: ", "neither true nor false"}},
    {"bad_seed", run_section + "seed = -1\n", {"e.ini:4: ", "[run] seed"}},
    {"missing_value",
     run_section + "[scale]\nsigma_range_m =\n",
     {"e.ini:5: ", "has no value", "default 0.02"}},
    {"value_is_all_comment", run_section + "[scale]\ngate_deg = ; later\n", {"e.ini:5: ", "has no value"}},
    {"key_twice",
     run_section + "[scale]\ngate_deg = 1\ngate_deg = 2\n",
     {"e.ini:6: ", "twice (first in line 5)"}},
    {"section_twice",
     run_section + "[scale]\n[outputs]\n[scale]\n",
     {"e.ini:6: ", "twice (first in line 4)"}},
    {"garbage_line", run_section + "sigma 0.2\n", {"e.ini:4: ", "\"sigma 0.2\" is neither"}},
    {"text_before_any_section",
     "maps = paper_map\n" + run_section,
     {"e.ini:1: ", "before the first [section]"}},
    {"open_header", run_section + "[scale\n", {"e.ini:4: ", "does not end in \"]\""}},
    {"no_key", run_section + "= 4\n", {"e.ini:4: ", "no key"}},
    {"binary", std::string("[run]\nrawlog = \0\0\0\n", 19), {"e.ini:2: ", "not a text file"}},
    {"unknown_module",
     "[run]\nrawlog = a.rawlog\nmodules = scale shfit\n",
     {"e.ini:3: ", "\"shfit\"", "\"shift\"?"}},
    {"module_twice", "[run]\nrawlog = a.rawlog\nmodules = scale scale\n", {"e.ini:3: ", "\"scale\" twice"}},
    {"map_builder_as_module",
     "[run]\nrawlog = a.rawlog\nmodules = paper_map\n",
     {"e.ini:3: ", "map builder", "[run] maps"}},
    {"module_as_map_builder",
     run_section + "maps = shift\n",
     {"e.ini:4: ", "which is a module", "[run] modules"}},
    {"unknown_map_builder", run_section + "maps = paper_mop\n", {"e.ini:4: ", "\"paper_map\"?"}},
    {"no_modules", "[run]\nrawlog = a.rawlog\n", {"e.ini:1: ", "[run] modules names no module", "scale"}},
    {"no_rawlog", "[run]\nmodules = scale\n", {"e.ini:1: ", "[run] rawlog names no log"}},
    {"empty_file", "", {"e.ini:1: ", "[run] modules", "[run] rawlog"}},
    {"trajectory_of_none",
     run_section + "trajectory = shift\n",
     {"e.ini:4: ", "\"shift\"", "not in [run] modules"}},
    {"missing_truth",
     run_section + "[evaluation]\ntruth = nowhere.tum\n",
     {"e.ini:5: ", "is not there", "nowhere.tum"}},
    {"unset_variable",
     run_section + "[evaluation]\ntruth = ${LOOPLINE_TEST_NONE}/t\n",
     {"e.ini:5: ", "${LOOPLINE_TEST_NONE}"}},
    {"module_says_no",
     run_section + "[scale]\nwindow_scans = 1\n",
     {"e.ini:4: ", "refine needs window_scans"}},
    {"wrong_key_of_a_module_that_is_not_used",
     run_section + "[shift]\nofset_m = 1\n",
     {"e.ini:5: ", "\"offset_m\"?"}},
    {"wrong_value_of_a_module_that_is_not_used",
     run_section + "[shift]\noffset_m = x\n",
     {"e.ini:5: ", "not a number"}},
    {"override_of_a_module_that_is_not_used",
     run_section,
     {"--set shift.offset_m=1: ", "no effect"},
     {"--set", "shift.offset_m=1"}},
    {"override_without_value",
     run_section,
     {"--set scale.refine: ", "section.key=value"},
     {"--set", "scale.refine"}},
    {"override_of_unknown_key",
     run_section,
     {"--set scale.refin=1: ", "\"refine\"?"},
     {"--set", "scale.refin=1"}},
    {"override_out_of_range",
     run_section,
     {"--set scale.gate_deg=91: ", "0 .. 90"},
     {"--set", "scale.gate_deg=91"}},
    {"missing_log_in_the_ini",
     "[run]\nrawlog = nowhere.rawlog\nmodules = scale\n",
     {"e.ini:2: ", "nowhere.rawlog"},
     {},
     3},
    {"missing_log_on_the_command_line",
     run_section,
     {"--rawlog ", "nowhere.rawlog"},
     {"--rawlog", "nowhere.rawlog"},
     3},
    {"folder_as_log", "[run]\nrawlog = .\nmodules = scale\n", {"e.ini:2: ", "folder"}, {}, 3},
    {"missing_log_and_more",
     "[run]\nrawlog = nowhere.rawlog\nmodules = scal\n",
     {"e.ini:2: ", "e.ini:3: ", "\"scale\"?"}},
};

class WrongIniTest : public testing::TestWithParam<WrongIni> {};

test::ProgramResult run_ini(const test::TemporaryFolder& folder, std::vector<std::string> words,
                            const std::vector<std::string>& more) {
    words.insert(words.end(), more.begin(), more.end());
    return test::run_loopline(words, {std::string("LOOPLINE_PLUGINS=") + test::fixture_folder() + "/good"},
                              folder.path());
}

}  // namespace

TEST_P(WrongIniTest, is_refused_by_run_and_check_alike_and_nothing_is_written) {
    const auto& wrong = GetParam();
    const test::TemporaryFolder folder;
    folder.write("a.rawlog", "");
    folder.write("e.ini", wrong.text);
    const auto run = run_ini(folder, {"run", "e.ini", "--out", "out/put"}, wrong.arguments);
    EXPECT_EQ(run.exit_code, wrong.exit_code) << run.err;
    for (const auto& words : wrong.said)
        EXPECT_NE(run.err.find(words), std::string::npos) << "\"" << words << "\" is not in:\n" << run.err;
    EXPECT_EQ(run.out, "");
    EXPECT_FALSE(std::filesystem::exists(folder / "out"));
    EXPECT_FALSE(std::filesystem::exists(folder / "runs"));

    const auto check = run_ini(folder, {"check", "e.ini"}, wrong.arguments);
    EXPECT_EQ(check.exit_code, run.exit_code);
    EXPECT_EQ(check.err, run.err);
    EXPECT_EQ(check.out, "");
}

INSTANTIATE_TEST_SUITE_P(All, WrongIniTest, testing::ValuesIn(wrong_inis),
                         [](const auto& wrong) { return wrong.param.name; });

TEST(WrongIni, all_problems_are_reported_together_in_the_order_of_the_file) {
    const test::TemporaryFolder folder;
    folder.write("a.rawlog", "");
    folder.write("e.ini", "[run]\nrawlog = a.rawlog\nmodules = scael\n[scale]\ngate_deg = x\n[what]\n");
    const auto result = run_ini(folder, {"check", "e.ini"}, {"--set", "scale"});
    std::vector<std::size_t> places;
    for (const char* start : {"e.ini:3: ", "\ne.ini:5: ", "\ne.ini:6: ", "\n--set scale: "})
        places.push_back(result.err.find(start));
    EXPECT_TRUE(std::is_sorted(places.begin(), places.end())) << result.err;
    EXPECT_NE(places.back(), std::string::npos) << result.err;
}

TEST(WrongIni, a_file_that_can_not_be_read_is_named) {
    const test::TemporaryFolder folder;
    EXPECT_EQ(run_ini(folder, {"check", "none.ini"}, {}).err, "none.ini: there is no such file\n");
    EXPECT_EQ(run_ini(folder, {"check", "."}, {}).exit_code, 2);
}

TEST(EffectiveIni, repeats_the_run_byte_for_byte) {
    const test::TemporaryFolder folder;
    const std::vector<std::string> estimate_only{"--quiet", "--set", "outputs.snapshots=false", "--set",
                                                 "outputs.report=false"};
    const auto run = [&](const std::string& ini, const std::string& out) {
        std::vector<std::string> words{"run", ini, "--out", (folder / out).string()};
        words.insert(words.end(), estimate_only.begin(), estimate_only.end());
        return test::run_loopline(words);
    };
    const auto first = run(test::source_folder() + "/ini/real/telecom_faculty_lines.ini", "first");
    ASSERT_EQ(first.exit_code, 0) << first.err;
    const auto again = run((folder / "first/config.ini").string(), "again");
    ASSERT_EQ(again.exit_code, 0) << again.err;
    for (const char* file : {"config.ini", "trajectory.tum", "covariance.csv", "map.lines.csv"}) {
        const std::string bytes = test::file_text(folder / "first" / file);
        EXPECT_FALSE(bytes.empty()) << file;
        EXPECT_TRUE(bytes == test::file_text(folder / "again" / file)) << file << " differs";
    }
}
