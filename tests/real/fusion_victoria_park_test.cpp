/// A car in a park, by wheels and trunks, over gaps of its fixes that are cut out on purpose.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "support/built_files.h"
#include "support/run_program.h"
#include "support/shared_data.h"

using namespace loopline;

TEST(FusionLogs, victoria_park_loses_less_than_two_percent_of_its_way_without_fixes) {
    NEEDS_SHARED_DATA("victoria_park/tree_features.csv");
    const test::TemporaryFolder folder;
    const std::string log = (folder / "log.rawlog").string();
    const auto imported =
        test::run_loopline({"import", "csv", (test::shared_data() / "victoria_park").string(), "--columns",
                            "victoria_park", "--out", log});
    ASSERT_EQ(imported.exit_code, 0) << imported.err;
    for (const auto& [gap_s, every_s] : {std::pair{"30", "100"}, {"60", "150"}}) {
        const auto result = test::run_loopline(
            {"run", test::source_folder() + "/ini/real/victoria_park.ini", "--rawlog", log, "--out",
             (folder / gap_s).string(), "--quiet", "--set", "outputs.snapshots=0", "--set",
             "outputs.report=0", "--set", std::string("fusion.withhold_s=") + gap_s, "--set",
             std::string("fusion.withhold_every_s=") + every_s});
        ASSERT_EQ(result.exit_code, 0) << result.err;
        const auto metrics = nlohmann::json::parse(test::file_text(folder / gap_s / "metrics.json"));
        double way_m = 0, off_m = 0;
        for (int gap = 1; gap <= metrics.at("gaps").get<int>(); ++gap) {
            const std::string name = "gap_" + std::string(gap < 10 ? "0" : "") + std::to_string(gap);
            way_m += metrics.at(name + "_way_m").get<double>();
            off_m += metrics.at(name + "_error_m").get<double>();
        }
        EXPECT_GT(way_m, 900);
        EXPECT_LT(off_m / way_m, 0.02) << gap_s;
    }
}
