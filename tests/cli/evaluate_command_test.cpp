/// loopline evaluate as a user runs it: the JSON keys that others rely on, the table, and every way of being
/// wrong.
#include <gtest/gtest.h>

#include <cstdio>
#include <nlohmann/json.hpp>

#include "support/run_program.h"

using namespace loopline::test;

namespace {

/// Along x at 1 m and 1 s a row, in TUM format, `scale` times as long; `sideways_m` off at the last pose.
std::string tum(int poses, double scale = 1, double sideways_m = 0, double first_s = 1000) {
    std::string text = "# t x y z qx qy qz qw\n";
    char line[200];
    for (int i = 0; i < poses; ++i) {
        std::snprintf(line, sizeof line, "%.9f %.9f %.9f 0 0 0 0 1\n", first_s + i, scale * i,
                      i == poses - 1 ? sideways_m : 0.0);
        text += line;
    }
    return text;
}

std::string flat(int poses) {
    std::string text;
    for (int i = 0; i < poses; ++i) text += std::to_string(1000 + i) + " " + std::to_string(i) + " 0 0\n";
    return text;
}

std::string kitti(int poses) {
    std::string text;
    for (int i = 0; i < poses; ++i) text += "1 0 0 " + std::to_string(i) + " 0 1 0 0 0 0 1 0\n";
    return text;
}

class EvaluateCommand : public ::testing::Test {
 protected:
    nlohmann::json json_of(std::vector<std::string> words) {
        words.insert(words.begin(), "evaluate");
        words.emplace_back("--json");
        const auto result = run_loopline(words);
        EXPECT_EQ(result.exit_code, 0) << result.err;
        EXPECT_EQ(result.err, "");
        return result.exit_code == 0 ? nlohmann::json::parse(result.out) : nlohmann::json();
    }
    TemporaryFolder folder;
};

}  // namespace

TEST_F(EvaluateCommand, prints_the_flat_keys_that_others_rely_on) {
    const std::string estimate = folder.write("estimate.tum", tum(251, 1.02)),
                      reference = folder.write("reference.txt", flat(251));
    const std::string relations =
        folder.write("a.relations", "1000 1010 10 0 0 0 0 0\n1000 1020.5 20 0 0 0 0 0\n5 6 1 0 0 0 0 0\n");
    const auto json =
        json_of({"--estimate", estimate, "--reference", reference, "--relations", relations, "--kitti"});
    for (const char* key : {"ate_rmse_m", "ate_max_m", "rpe_translation_m", "rpe_rotation_deg",
                            "kitti_translation_percent", "kitti_rotation_deg_per_m",
                            "relations_translation_mean_m", "relations_rotation_mean_deg", "relations_used"})
        EXPECT_TRUE(json.contains(key) && json[key].is_number()) << key;
    // Centred on its middle, a path that is 2 % too long is off by 2 % of the way from there.
    EXPECT_NEAR(json["ate_max_m"], 0.02 * 125, 1e-9);
    EXPECT_NEAR(json["ate_rmse_m"], 0.02 * std::sqrt((251.0 * 251 - 1) / 12), 1e-9);
    EXPECT_NEAR(json["rpe_translation_m"], 0.02, 1e-9);
    EXPECT_NEAR(json["relations_translation_mean_m"], (0.2 + 0.91) / 2, 1e-9);
    EXPECT_EQ(json["relations_used"], 2);
    EXPECT_EQ(json["relations_total"], 3);
    EXPECT_EQ(json["poses_matched"], 251);
    for (const auto& [key, value] : json.items())
        EXPECT_FALSE(value.is_structured()) << key << " is not flat";
}

TEST_F(EvaluateCommand, only_what_was_asked_for_is_there) {
    const std::string estimate = folder.write("estimate.tum", tum(20)),
                      relations = folder.write("a.relations", "1000 1010 10 0 0 0 0 0\n");
    const auto json = json_of({"--estimate", estimate, "--relations", relations});
    EXPECT_FALSE(json.contains("ate_rmse_m"));
    EXPECT_FALSE(json.contains("kitti_translation_percent"));
    EXPECT_NEAR(json["relations_translation_mean_m"], 0, 1e-9);
}

TEST_F(EvaluateCommand, takes_files_without_times_by_their_rows) {
    const std::string estimate = folder.write("estimate.tum", tum(251)),
                      reference = folder.write("00.txt", kitti(251));
    const auto json = json_of({"--estimate", estimate, "--reference", reference, "--kitti"});
    EXPECT_NEAR(json["kitti_translation_percent"], 0, 1e-9);
    EXPECT_EQ(json["kitti_segments"], 20);
}

TEST_F(EvaluateCommand, stamps_that_go_backwards_and_a_clock_that_is_off) {
    std::string backwards;
    for (int i = 19; i >= 0; --i) backwards += std::to_string(1000 + i) + " " + std::to_string(i) + " 0 0\n";
    const std::string reference = folder.write("reference.txt", backwards);
    EXPECT_NEAR(
        json_of({"--estimate", folder.write("a.tum", tum(20)), "--reference", reference})["ate_max_m"], 0,
        1e-9);
    const auto shifted = json_of({"--estimate", folder.write("b.tum", tum(20, 1, 0, 500.25)), "--reference",
                                  reference, "--time-offset-s", "499.75"});
    EXPECT_NEAR(shifted["ate_max_m"], 0, 1e-9);
    EXPECT_EQ(shifted["poses_matched"], 20);
}

TEST_F(EvaluateCommand, the_step_of_the_rpe_and_the_alignment_can_be_chosen) {
    const std::string estimate = folder.write("estimate.tum", tum(101, 1.01)),
                      reference = folder.write("reference.txt", flat(101));
    EXPECT_NEAR(json_of({"--estimate", estimate, "--reference", reference, "--rpe-distance-m",
                         "20"})["rpe_translation_m"],
                0.2, 1e-9);
    EXPECT_NEAR(json_of({"--estimate", estimate, "--reference", reference, "--rpe-time-s",
                         "50"})["rpe_translation_m"],
                0.5, 1e-9);
    EXPECT_NEAR(json_of({"--estimate", estimate, "--reference", reference, "--align", "none"})["ate_max_m"],
                1.0, 1e-9);
}

TEST_F(EvaluateCommand, the_table_says_the_same_in_words) {
    const std::string estimate = folder.write("estimate.tum", tum(20, 1.1)),
                      reference = folder.write("reference.txt", flat(20));
    const auto result = run_loopline({"evaluate", "--estimate", estimate, "--reference", reference});
    EXPECT_EQ(result.exit_code, 0);
    EXPECT_NE(result.out.find("20 of 20 poses matched with the reference's 20, 19.0 m; planar alignment"),
              std::string::npos)
        << result.out;
    EXPECT_NE(result.out.find("ATE"), std::string::npos);
    EXPECT_NE(result.out.find("0.9500"), std::string::npos) << "the largest error: 0.1 of 9.5 m\n"
                                                            << result.out;
}

TEST_F(EvaluateCommand, what_is_wrong_ends_with_its_exit_code_and_one_sentence) {
    const std::string good = folder.write("good.tum", tum(20)),
                      later = folder.write("later.tum", tum(20, 1, 0, 5000));
    const std::string bad = folder.write("bad.tum", "1 2 3\n"), empty = folder.write("empty.tum", "");
    const std::string relations = folder.write("r.relations", "1 2 1 0 0 0 0 0\n"),
                      rows = folder.write("00.txt", kitti(7));
    const std::string short_relation = folder.write("s.relations", "# t1 t2\n1 2 1\n");
    const std::string nowhere = (folder / "nowhere.tum").string();
    const struct {
        std::vector<std::string> words;
        int exit_code;
        std::vector<std::string> said;
    } cases[] = {
        {{}, 2, {"--estimate"}},
        {{"--estimate", good}, 2, {"--reference", "--relations"}},
        {{"--estimate", nowhere, "--reference", good}, 3, {"the estimate", "nowhere.tum"}},
        {{"--estimate", good, "--reference", nowhere}, 3, {"the reference", "nowhere.tum"}},
        {{"--estimate", good, "--relations", nowhere}, 3, {"the relations", "nowhere.tum"}},
        {{"--estimate", good, "--reference", later},
         3,
         {"1000.000000000 to 1019.000000000", "5000.000000000 to 5019.000000000"}},
        {{"--estimate", bad, "--reference", good}, 3, {"bad.tum:1:"}},
        {{"--estimate", good, "--reference", empty}, 3, {"empty.tum has no pose"}},
        {{"--estimate", good, "--relations", relations},
         3,
         {"none of the 1 relations", "1000.000000000 to 1019.000000000"}},
        {{"--estimate", good, "--relations", short_relation}, 3, {"s.relations:2:"}},
        {{"--estimate", good, "--reference", rows}, 3, {"has 20 poses", "has 7:"}},
        {{"--estimate", rows, "--relations", relations}, 3, {"has no times"}},
        {{"--estimate", good, "--reference", good, "--kitti"}, 3, {"longer than 100 m"}},
        {{"--estimate", good, "--reference", good, "--align", "4d"}, 2, {"--align"}},
        {{"--estimate", good, "--reference", good, "--max-difference-s", "-1"}, 2, {"--max-difference-s"}},
        {{"--estimate", good, "--reference", good, "--rpe-poses", "2", "--rpe-time-s", "1"}, 2, {"--rpe-"}},
        {{"--estimate", good, "--reference", good, "--odometry", good}, 2, {"--relations"}},
        {{"--estimate", good, "--referense", good}, 2, {"--referense"}},
    };
    for (const auto& c : cases) {
        std::vector<std::string> words{"evaluate"};
        words.insert(words.end(), c.words.begin(), c.words.end());
        const auto result = run_loopline(words);
        EXPECT_EQ(result.exit_code, c.exit_code) << result.err;
        EXPECT_EQ(result.out, "");
        for (const auto& part : c.said)
            EXPECT_NE(result.err.find(part), std::string::npos)
                << "expected: " << part << "\nsaid: " << result.err;
    }
}
