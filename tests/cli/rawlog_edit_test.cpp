/// Our plugins load into MRPT's own programs: rawlog-edit lists what we recorded, with `-p`, and not without.
#include <gtest/gtest.h>

#include <regex>

#include "cli/run_support.h"
#include "support/plugin_environment.h"

using namespace loopline;
using namespace loopline::testing;

TEST(RawlogEdit, lists_recorded_lines_with_our_plugin) {
    if (test::run_program({"which", "rawlog-edit"}).exit_code != 0)
        GTEST_SKIP() << "rawlog-edit is not installed (package mrpt-apps)";
    const SmallRun small("lines");
    ASSERT_EQ(small.run(telecom_log, {"--set", "outputs.record=CObservationLines"}).exit_code, 0);
    const std::string recorded = small.out() + "/recorded.rawlog";
    const auto with = test::run_program(
        {"rawlog-edit", "-p", test::plugin_folder() + "/libloopline_lines.so", "--info", "-i", recorded},
        test::environment_of_our_plugins());
    EXPECT_EQ(with.exit_code, 0) << with.err;
    EXPECT_TRUE(std::regex_search(with.out, std::regex("Overall number of objects *: 225\n"))) << with.out;
    EXPECT_TRUE(std::regex_search(with.out, std::regex("All sensor labels *: lines\n"))) << with.out;
    const auto without = test::run_program({"rawlog-edit", "--info", "-i", recorded});
    EXPECT_FALSE(std::regex_search(without.out, std::regex("objects *: 225"))) << "it needs the plugin";
}
