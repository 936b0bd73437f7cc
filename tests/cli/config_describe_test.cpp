/// `loopline describe`: the same declarations as text, as .ini and as the manual.
#include <gtest/gtest.h>

#include "support/built_files.h"
#include "support/run_program.h"

using namespace loopline;

namespace {

const std::vector<std::string> fixtures{std::string("LOOPLINE_PLUGINS=") + test::fixture_folder() + "/good",
                                        "COLUMNS=80"};

std::string described(std::vector<std::string> words) {
    words.insert(words.begin(), "describe");
    const auto result = test::run_loopline(words, fixtures);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return result.out;
}

}  // namespace

TEST(Describe, lists_everything_with_what_it_needs) {
    const std::string text = described({});
    for (const char* words : {"  scale ", "  shift ", "  paper_map ", "  run ", "  outputs ", "  evaluation ",
                              "needs CObservation2DRangeScan; publishes CObservationComment"})
        EXPECT_NE(text.find(words), std::string::npos) << words;
}

TEST(Describe, shows_each_key_with_default_unit_range_and_sentence) {
    const std::string text = described({"scale"});
    EXPECT_NE(text.find("  sigma_range_m  0.02 m   0 .. 1           Range noise.\n"), std::string::npos)
        << text;
    EXPECT_NE(text.find("  method         plain    plain | careful  How to scale.\n"), std::string::npos)
        << text;
}

TEST(Describe, the_ini_is_a_configuration_that_can_be_checked) {
    const test::TemporaryFolder folder;
    folder.write("a.rawlog", "");
    const auto path = folder.write("all.ini", described({"--ini"}));
    const auto alone = test::run_loopline({"check", path}, fixtures);
    EXPECT_EQ(alone.exit_code, 2) << "it names neither log nor modules";
    EXPECT_EQ(alone.err.find("not a key"), std::string::npos) << alone.err;
    folder.write("one.ini", "[run]\nrawlog = a.rawlog\nmodules = scale\n" + described({"scale", "--ini"}));
    EXPECT_EQ(test::run_loopline({"check", (folder / "one.ini").string()}, fixtures).err.find(".ini:"),
              std::string::npos);
}

TEST(Describe, markdown_escapes_what_would_end_a_cell) {
    const std::string text = described({"scale", "--markdown"});
    EXPECT_NE(text.find("| `method` | `plain` |  | plain \\| careful | How to scale. |\n"), std::string::npos)
        << text;
}

TEST(Describe, the_manual_in_docs_is_up_to_date) {
    const auto result = test::run_loopline({"describe", "--markdown"});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    EXPECT_EQ(result.out, test::file_text(test::source_folder() + "/docs/ini-reference.md"))
        << "docs/ini-reference.md is stale; make it again with\n"
           "  build/release/bin/loopline describe --markdown > docs/ini-reference.md";
}
