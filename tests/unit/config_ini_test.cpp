/// The .ini reader, the nearest name, and paths.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <random>
#include <set>

#include "config/did_you_mean.h"
#include "config/ini_file.h"
#include "config/paths.h"
#include "support/run_program.h"

using namespace loopline;

namespace {

std::string value_of(const std::string& line) {
    IniFile file = parse_ini_text("[a]\n" + line + "\n", "f.ini");
    return file.problems.empty() && file.find("a")->find("k") ? file.find("a")->find("k")->value : "PROBLEM";
}

std::vector<std::string> problems_of(const std::string& text) {
    std::vector<std::string> lines;
    for (const auto& problem : parse_ini_text(text, "f.ini").problems)
        lines.push_back(problem.origin.text + ": " + problem.sentence);
    return lines;
}

}  // namespace

TEST(IniFile, keeps_the_line_of_every_entry_whatever_the_line_ends) {
    for (const std::string end : {"\n", "\r\n"}) {
        IniFile file = parse_ini_text("\xEF\xBB\xBF; head" + end + "[a]" + end + end + "k = 1" + end +
                                          "[ b ]" + end + "\tlast\t=\tx y\t" + end + "no_end = 2",
                                      "dir/f.ini");
        ASSERT_TRUE(file.problems.empty());
        EXPECT_EQ(file.find("a")->find("k")->origin.text, "dir/f.ini:4");
        EXPECT_EQ(file.find("b")->find("last")->value, "x y");
        EXPECT_EQ(file.find("b")->find("last")->origin.line, 6);
        EXPECT_EQ(file.find("b")->find("no_end")->value, "2");
    }
}

TEST(IniFile, comments_open_at_a_line_start_or_after_a_blank_only) {
    EXPECT_EQ(value_of("k = 3 ; c"), "3");
    EXPECT_EQ(value_of("k = 3\t# c"), "3");
    EXPECT_EQ(value_of("k = 3 // c"), "3");
    EXPECT_EQ(value_of("k = a;b#c//d"), "a;b#c//d");
    EXPECT_EQ(value_of("k = http://x/y"), "http://x/y");
    EXPECT_EQ(value_of("k = ; c"), "");
    EXPECT_EQ(value_of("k ="), "");
    EXPECT_EQ(value_of("k = a = b"), "a = b");
    for (const char* comment : {"; k = 1", "# [x", "   // k", "  ;", ""})
        EXPECT_TRUE(problems_of(comment).empty()) << comment;
}

TEST(IniFile, quotes_keep_what_would_be_a_comment) {
    EXPECT_EQ(value_of("k = \" a # b \" ; c"), " a # b ");
    EXPECT_EQ(value_of("k = \"\""), "");
    EXPECT_EQ(value_of("k = \"open"), "\"open");
    EXPECT_EQ(value_of("k = \"a\" b"), "\"a\" b");
}

TEST(IniFile, a_semicolon_opens_no_comment_in_a_list_that_it_separates) {
    IniFile file = parse_ini_text("[a]\nk = one ; two # comment\n", "f.ini");
    EXPECT_EQ(file.find("a")->find("k")->value, "one");
    EXPECT_EQ(file.find("a")->find("k")->list_value, "one ; two");
}

TEST(IniFile, every_assignment_reads_back) {
    for (const std::string value :
         {"", "a", "a b", "a;b", "a ; b", "a #b", "//x", " a", "a ", "\"a\"x", "#", "a; b"}) {
        IniFile file = parse_ini_text("[a]\n" + ini_assignment("k", value) + "\n", "f.ini");
        ASSERT_TRUE(file.find("a")->find("k")) << value;
        EXPECT_EQ(file.find("a")->find("k")->value, value) << ini_assignment("k", value);
        EXPECT_EQ(file.find("a")->find("k")->list_value, value) << ini_assignment("k", value);
    }
}

TEST(IniFile, reports_all_that_it_can_not_understand) {
    const auto lines = problems_of("k = 1\n[a]\nstray\n= 2\nk = 1\nk = 2\n[a]\n[]\n[b\n[c] d\n");
    const std::vector<std::string> starts{"f.ini:1: \"k\" stands before the first [section]",
                                          "f.ini:3: \"stray\" is neither",
                                          "f.ini:4: there is no key",
                                          "f.ini:6: [a] k stands there twice (first in line 5)",
                                          "f.ini:7: the section [a] stands there twice (first in line 2)",
                                          "f.ini:8: the section header [] has no name",
                                          "f.ini:9: the section header [b does not end",
                                          "f.ini:10: the section header [c] d does not end"};
    ASSERT_EQ(lines.size(), starts.size());
    for (std::size_t i = 0; i < lines.size(); ++i) EXPECT_EQ(lines[i].rfind(starts[i], 0), 0u) << lines[i];
}

TEST(IniFile, binary_junk_is_one_problem) {
    EXPECT_EQ(problems_of(std::string("[a]\nk = 1\0\n\0\0\n", 14)).size(), 1u);
    EXPECT_EQ(problems_of("\x1f\x8b\x08junk\n\x01\n").size(), 1u);
    EXPECT_NE(problems_of(std::string("\xFF\xFE[\0a\0]\0", 8)).front().find("UTF-8"), std::string::npos);
    EXPECT_TRUE(problems_of("; Kn\xFCppel\n[a]\nk = \xC3\xBC\n").empty()) << "other alphabets are text";
}

TEST(IniFile, unreadable_files_are_problems_and_no_exceptions) {
    const test::TemporaryFolder folder;
    const auto complaint = [](const std::string& path) {
        return read_ini_file(path).problems.at(0).sentence;
    };
    EXPECT_NE(complaint(folder / "none.ini").find("no such file"), std::string::npos);
    EXPECT_NE(complaint(folder.path()).find("folder"), std::string::npos);
    EXPECT_NE(complaint("").find("empty"), std::string::npos);
    EXPECT_NE(complaint("/dev/zero").find("not a text file"), std::string::npos);
    EXPECT_NE(complaint(folder.write("long.ini", std::string(5 << 20, ' '))).find("4 MB"), std::string::npos);
    EXPECT_TRUE(read_ini_file(folder.write("empty.ini", "")).problems.empty());
}

TEST(IniFile, the_last_override_counts) {
    IniFile file = parse_ini_text("[a]\nk = 1\n", "f.ini");
    apply_override(file, "a.k=2");
    apply_override(file, "a.k= 3 ");
    apply_override(file, "b.x.y=p=q ; r");
    EXPECT_EQ(file.find("a")->find("k")->value, "3");
    EXPECT_EQ(file.find("a")->find("k")->origin.text, "--set a.k= 3 ");
    EXPECT_EQ(file.find("b")->find("x.y")->value, "p=q ; r");
    for (const char* bad : {"", "a", "a.k", "=", ".k=1", "a.=1", "k=1", "k=a.b", "a.k=1\nb"}) {
        IniFile broken = parse_ini_text("", "f.ini");
        apply_override(broken, bad);
        EXPECT_EQ(broken.problems.size(), 1u) << bad;
        EXPECT_TRUE(broken.sections.empty()) << bad;
    }
}

TEST(IniFile, any_text_is_taken_and_no_line_is_lost_twice) {
    std::mt19937_64 random(7);
    const std::string letters = "[]=;#/\" \t\n\rab\xC3\xBC";
    std::uniform_int_distribution<std::size_t> letter(0, letters.size() - 1), length(0, 80);
    for (int i = 0; i < 5000; ++i) {
        std::string text;
        for (std::size_t n = length(random); n > 0; --n) text += letters[letter(random)];
        const IniFile file = parse_ini_text(text, "f.ini");
        const auto lines = static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n') + 1);
        std::set<int> understood;
        for (const auto& section : file.sections) {
            EXPECT_TRUE(understood.insert(section.origin.line).second) << text;
            for (const auto& entry : section.entries)
                EXPECT_TRUE(understood.insert(entry.origin.line).second) << text;
        }
        for (const auto& problem : file.problems)
            EXPECT_TRUE(understood.insert(problem.origin.line).second) << text;
        EXPECT_LE(understood.size(), lines);
    }
}

TEST(DidYouMean, distance_is_that_of_known_pairs_and_symmetric) {
    EXPECT_EQ(edit_distance("kitten", "sitting"), 3u);
    EXPECT_EQ(edit_distance("", "abc"), 3u);
    EXPECT_EQ(edit_distance("ab", "ba"), 1u);
    EXPECT_EQ(edit_distance("ca", "abc"), 3u) << "no part is edited twice";
    EXPECT_EQ(edit_distance("Gap_M", "gap_m"), 0u);
    EXPECT_EQ(edit_distance("abcdef", "abdcfe"), edit_distance("abdcfe", "abcdef"));
}

TEST(DidYouMean, finds_the_nearest_and_says_nothing_where_none_is_near) {
    const std::vector<std::string> keys{"sigma_range_m", "sigma_angle_deg", "gate"};
    EXPECT_EQ(nearest_name("sigma_rnage_m", keys), "sigma_range_m");
    EXPECT_EQ(nearest_name("sigma_range", keys), "sigma_range_m");
    EXPECT_EQ(nearest_name("angle", keys), "sigma_angle_deg") << "a part of the name";
    EXPECT_EQ(nearest_name("zzz", keys), "");
    EXPECT_EQ(nearest_name("x", {}), "");
    EXPECT_EQ(did_you_mean("gaet", keys), "; did you mean \"gate\"?");
    EXPECT_EQ(listing({"a", "b", "c"}), "a, b and c");
}

TEST(ExpandPath, takes_relative_ones_from_the_base_and_replaces_variables) {
    setenv("LOOPLINE_TEST_PLACE", "/some/where", 1);
    EXPECT_EQ(expand_path("x/../y.rawlog", "/base").path, "/base/y.rawlog");
    EXPECT_EQ(expand_path("/abs/a b.rawlog", "/base").path, "/abs/a b.rawlog");
    EXPECT_EQ(expand_path("${LOOPLINE_TEST_PLACE}/${LOOPLINE_TEST_PLACE}/c", "/base").path,
              "/some/where/some/where/c");
    EXPECT_EQ(expand_path("$HOME {x}", "/base").path, "/base/$HOME {x}");
    EXPECT_EQ(expand_path("", "/base").path, "");
    EXPECT_NE(expand_path("${LOOPLINE_TEST_NOTHING}/x", "/base").problem.find("not set"), std::string::npos);
    EXPECT_NE(expand_path("${OPEN", "/base").problem.find("}"), std::string::npos);
    EXPECT_EQ(expand_path("x", "").path, std::filesystem::current_path() / "x");
}
