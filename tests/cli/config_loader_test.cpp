/// Plugins that can't be used are refused with one sentence, through the program.
#include <gtest/gtest.h>

#include <algorithm>

#include "api/module.h"
#include "support/run_program.h"

using namespace loopline;

namespace {

test::ProgramResult run_with_plugins(const std::string& folder) {
    const test::TemporaryFolder scratch;
    scratch.write("a.rawlog", "");
    return test::run_loopline(
        {"check", scratch.write("e.ini", "[run]\nrawlog = a.rawlog\nmodules = first\n")},
        {"LOOPLINE_PLUGINS=" + folder});
}

void expect_refused(const std::string& fixture, const std::vector<std::string>& words) {
    const auto result = run_with_plugins(test::fixture_folder() + "/" + fixture);
    EXPECT_EQ(result.exit_code, 2) << fixture;
    EXPECT_EQ(result.out, "") << fixture;
    for (const auto& word : words)
        EXPECT_NE(result.err.find(word), std::string::npos) << word << " not in " << result.err;
}

}  // namespace

TEST(PluginLoader, one_class_in_two_libraries_is_refused_and_both_are_named) {
    expect_refused("duplicate_class", {"loopline::fixtures::TinyModule", "libfirst.so", "libsecond.so"});
}

TEST(PluginLoader, one_name_in_two_libraries_is_refused_and_both_are_named) {
    expect_refused("duplicate_name", {"\"tiny\"", "libfirst.so", "libsecond.so"});
}

TEST(PluginLoader, a_module_may_not_take_a_section_of_the_host) {
    expect_refused("host_name", {"\"outputs\"", "libthief.so"});
}

TEST(PluginLoader, another_version_of_the_contract_is_refused) {
    expect_refused("wrong_version", {"libold.so", "loopline-api-0", LOOPLINE_API_VERSION});
}

TEST(PluginLoader, a_library_without_a_version_is_refused_though_one_that_it_needs_has_one) {
    expect_refused("no_version", {"libanonymous.so", "not a Loopline plugin"});
}

TEST(PluginLoader, a_missing_symbol_is_named_at_load_time) {
    expect_refused("undefined_symbol", {"libbroken.so", "a_function_that_nobody_has_written()"});
}

TEST(PluginLoader, a_file_that_is_no_library_and_a_missing_folder_are_refused) {
    const test::TemporaryFolder folder;
    folder.write("text.so", "no library");
    const auto junk = run_with_plugins(folder.path());
    EXPECT_EQ(junk.exit_code, 2);
    EXPECT_NE(junk.err.find("text.so"), std::string::npos) << junk.err;
    const auto missing = run_with_plugins(folder / "none");
    EXPECT_EQ(missing.exit_code, 2);
    EXPECT_NE(missing.err.find("none can't be read"), std::string::npos) << missing.err;
}

TEST(PluginLoader, a_library_that_another_one_has_brought_along_is_no_duplicate) {
    // line_slam links lines, and comes first in name order.
    const auto result = test::run_loopline({"check", "/nowhere.ini"});
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_EQ(result.err, "/nowhere.ini: there is no such file\n");
}
