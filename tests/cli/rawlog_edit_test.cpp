/// Our plugins load into MRPT's own programs: rawlog-edit lists what we recorded, with `-p`, and not without.
#include <gtest/gtest.h>

#include "cli/run_support.h"

using namespace loopline;
using namespace loopline::testing;

TEST(RawlogEdit, lists_recorded_lines_with_our_plugin) {
    if (test::run_program({"which", "rawlog-edit"}).exit_code != 0)
        GTEST_SKIP() << "rawlog-edit is not installed (package mrpt-apps)";
    const SmallRun small("lines");
    ASSERT_EQ(small.run(telecom_log, {"--set", "outputs.record=CObservationLines"}).exit_code, 0);
    const std::string recorded = small.out() + "/recorded.rawlog";
    const auto with = test::run_program(
        {"rawlog-edit", "-p", LOOPLINE_PLUGIN_FOLDER "/libloopline_lines.so", "--info", "-i", recorded});
    EXPECT_EQ(with.exit_code, 0) << with.err;
    EXPECT_NE(with.out.find("CObservationLines"), std::string::npos) << with.out;
    EXPECT_NE(with.out.find("225"), std::string::npos) << with.out;
    const auto without = test::run_program({"rawlog-edit", "--info", "-i", recorded});
    EXPECT_EQ(without.out.find("225"), std::string::npos) << "it needs the plugin: " << without.out;
}
