/// Help, misspelt commands and options, and pipes that close early.
#include <gtest/gtest.h>

#include <sstream>

#include "support/run_program.h"

using namespace loopline;

namespace {

std::size_t longest_line(const std::string& text) {
    std::size_t longest = 0;
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);)
        if (line.rfind("  loopline run ini/", 0) != 0)
            longest = std::max(longest, line.size());  // to copy: not broken
    return longest;
}

const std::vector<std::string> commands{"run", "evaluate", "render", "check", "describe", "import"};

}  // namespace

TEST(Help, no_command_prints_the_help_as_an_error) {
    const auto result = test::run_loopline({});
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_EQ(result.out, "");
    EXPECT_EQ(result.err, test::run_loopline({"--help"}).out);
    for (const auto& command : commands)
        EXPECT_NE(result.err.find("\n  " + command + " "), std::string::npos) << command;
    EXPECT_NE(result.err.find("Exit codes"), std::string::npos);
}

TEST(Help, all_ways_to_ask_for_it_agree) {
    for (const auto& command : commands) {
        const auto result = test::run_loopline({command, "--help"});
        EXPECT_EQ(result.exit_code, 0) << command;
        EXPECT_EQ(result.err, "") << command;
        EXPECT_NE(result.out.find("Usage:\n  loopline " + command), std::string::npos) << result.out;
        EXPECT_EQ(result.out, test::run_loopline({"help", command}).out);
        EXPECT_EQ(result.out, test::run_loopline({command, "-h"}).out);
    }
    EXPECT_EQ(test::run_loopline({"help"}).out, test::run_loopline({"-h"}).out);
    EXPECT_EQ(test::run_loopline({"--version"}).out.rfind("loopline ", 0), 0u);
}

TEST(Help, a_command_inside_a_command_has_its_own) {
    const auto result = test::run_loopline({"import", "carmen", "--help"});
    EXPECT_EQ(result.exit_code, 0);
    EXPECT_NE(result.out.find("Usage:\n  loopline import carmen IN..."), std::string::npos) << result.out;
    EXPECT_EQ(result.out, test::run_loopline({"help", "import", "carmen"}).out);
}

TEST(CommandLine, plugins_that_can_not_be_loaded_are_a_sentence_for_every_command) {
    for (const std::vector<std::string>& words :
         std::vector<std::vector<std::string>>{{"import", "carmen"}, {"describe"}, {"check", "e.ini"}}) {
        const auto result = test::run_loopline(words, {"LOOPLINE_PLUGINS=/nowhere"});
        EXPECT_EQ(result.exit_code, 2) << words[0];
        EXPECT_EQ(result.err.rfind("loopline: the plugin folder /nowhere can't be read", 0), 0u)
            << result.err;
    }
}

TEST(Help, fits_the_terminal) {
    for (const std::size_t columns : {40u, 80u, 100u}) {
        const std::string width = "COLUMNS=" + std::to_string(columns);
        EXPECT_LT(longest_line(test::run_loopline({"--help"}, {width}).out), columns);
        EXPECT_LT(longest_line(test::run_loopline({"describe", "run"}, {width}).out), columns);
        for (const auto& command : commands)
            EXPECT_LT(longest_line(test::run_loopline({command, "--help"}, {width}).out), columns) << command;
    }
}

TEST(CommandLine, misspelt_words_are_answered_with_the_nearest) {
    const auto expect = [](const std::vector<std::string>& words, const std::string& said) {
        const auto result = test::run_loopline(words);
        EXPECT_EQ(result.exit_code, 2) << said;
        EXPECT_EQ(result.out, "") << said;
        EXPECT_NE(result.err.find(said), std::string::npos) << result.err;
        EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
    };
    expect({"rnu", "e.ini"}, "there is no command \"rnu\"; did you mean \"run\"?");
    expect({"zzzzzz"}, "the commands are run, ");
    expect({"help", "chekc"}, "did you mean \"check\"?");
    expect({"--hepl"}, "did you mean \"--help\"?");
    expect({"check", "e.ini", "--rawlgo=f"},
           "loopline check: there is no option \"--rawlgo\"; did you mean \"--rawlog\"?");
    expect({"check"}, "loopline check: CONFIG.ini is missing");
    expect({"check", "a.ini", "b.ini"}, "no place for the argument \"b.ini\"");
    expect({"check", "a.ini", "--set"}, "--set needs a value");
    expect({"import", "carmen", "a.log", "--oot", "b"},
           "there is no option \"--oot\"; did you mean \"--out\"?");
    expect({"describe", "ruin"}, "\"ruin\"; did you mean \"run\"?");
    expect({"describe", "--ini", "--markdown"}, "--ini excludes --markdown");
}

TEST(CommandLine, an_option_that_may_repeat_takes_one_value_each_time) {
    const auto result = test::run_loopline({"check", "--set", "a.b=c", "--set", "d.e=f", "/nowhere.ini"});
    EXPECT_EQ(result.err, "/nowhere.ini: there is no such file\n");
}

TEST(CommandLine, a_pipe_that_closes_early_is_no_error_and_a_full_disk_is_one) {
    const std::string program = test::loopline_program();
    const auto piped =
        test::run_program({"bash", "-c", "set -o pipefail; " + program + " describe --markdown | head -1"});
    EXPECT_EQ(piped.exit_code, 0);
    EXPECT_EQ(piped.err, "");
    EXPECT_EQ(piped.out, "# .ini reference\n");
    const auto closed = test::run_program({"bash", "-c", program + " describe --markdown | true"});
    EXPECT_EQ(closed.err, "");
    const auto full = test::run_program({"bash", "-c", program + " describe > /dev/full"});
    EXPECT_EQ(full.exit_code, 2);
    EXPECT_EQ(full.err, "loopline: the output could not be written to its end\n");
}
