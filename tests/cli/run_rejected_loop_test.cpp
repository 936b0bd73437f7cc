/// Loops that people decide on, with the program.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "support/ring_log.h"

using namespace loopline::test;
using nlohmann::json;

namespace {

class RingProgram {
 public:
    RingProgram() {
        folder_.write("ring.ini", "[run]\nrawlog = " + ring_log() +
                                      "\nmodules = odometry grid_slam\n[outputs]\nsnapshots = false\n"
                                      "report = false\n[grid_slam]\nactive_sigma_m = 0.08\n");
    }
    ProgramResult run(const std::vector<std::string>& more) const {
        std::vector<std::string> words{"run", ini(), "--out", (folder_ / "out").string(), "--quiet"};
        words.insert(words.end(), more.begin(), more.end());
        return run_loopline(words);
    }
    ProgramResult run_with(const std::string& key, const std::string& value) const {
        return run({"--set", "grid_slam." + key + "=" + value});
    }
    std::string ini() const { return (folder_ / "ring.ini").string(); }
    std::string out(const std::string& file) const { return (folder_ / ("out/" + file)).string(); }
    json loops() const { return json::parse(file_text(out("metrics.json")))["loops"]; }
    json accepted() const {
        for (const auto& loop : loops())
            if (loop["decision"] == "accepted") return loop;
        return {};
    }
    std::vector<std::string> warnings() const {
        return json::parse(file_text(out("manifest.json")))["warnings"];
    }

 private:
    TemporaryFolder folder_;
};

}  // namespace

TEST(RunRejectedLoop, config_ini_of_the_run_repeats_it) {
    const RingProgram ring;
    ASSERT_EQ(ring.run({}).exit_code, 0);
    const json loop = ring.accepted();
    const std::string number = std::to_string(loop["number"].get<int>());
    const auto said = ring.run({"--reject-loop", number});
    EXPECT_EQ(said.exit_code, 0);
    EXPECT_EQ(said.err, "");
    const std::string config = file_text(ring.out("config.ini")),
                      path = file_text(ring.out("trajectory.tum"));
    EXPECT_NE(config.find("\nrefuse_loops = " + loop["loop"].get<std::string>() + "\n"), std::string::npos);
    const auto files = json::parse(file_text(ring.out("manifest.json")))["files"];
    for (const auto& file : files)
        EXPECT_NE(file, "states/loop_" + number + ".bin") << "the loop is none any more";

    TemporaryFolder elsewhere;
    const std::string again = (elsewhere / "again").string();
    ASSERT_EQ(run_loopline({"run", ring.out("config.ini"), "--out", again, "--quiet"}).exit_code, 0);
    EXPECT_EQ(file_text(again + "/config.ini"), config);
    EXPECT_TRUE(file_text(again + "/trajectory.tum") == path);
    EXPECT_EQ(ring.run({"--reject-loop", number}).exit_code, 2) << "it is not accepted any more";
}

TEST(RunRejectedLoop, errors_end_with_2_and_one_sentence) {
    const RingProgram ring;
    const auto none = ring.run({"--reject-loop", "1"});
    EXPECT_EQ(none.exit_code, 2);
    EXPECT_EQ(none.err.find("loopline: --reject-loop: there is no run in "), 0u) << none.err;
    for (const char* number : {"-1", "x", "1.5"}) EXPECT_EQ(ring.run({"--reject-loop", number}).exit_code, 2);
    EXPECT_EQ(ring.run({"--reject-loop", "1", "--resume"}).exit_code, 2);
    EXPECT_FALSE(std::filesystem::exists(ring.out("")));
}

TEST(RunRejectedLoop, without_a_state_it_says_that_it_starts_over) {
    const RingProgram ring;
    ASSERT_EQ(ring.run({"--set", "outputs.states_mb=0"}).exit_code, 0);
    const std::string number = std::to_string(ring.accepted()["number"].get<int>());
    const auto said = run_loopline(
        {"run", ring.ini(), "--out", ring.out(""), "--set", "outputs.states_mb=0", "--reject-loop", number});
    EXPECT_EQ(said.exit_code, 0);
    EXPECT_NE(said.err.find("no state is kept from before loop " + number), std::string::npos) << said.err;
}

TEST(RunNamedLoop, is_closed_where_none_is_looked_for) {
    const RingProgram ring;
    ASSERT_EQ(ring.run({}).exit_code, 0);
    const json loop = ring.accepted();
    ASSERT_EQ(ring.run({"--set", "grid_slam.loops=no", "--set",
                        "grid_slam.named_loops=" + loop["loop"].get<std::string>()})
                  .exit_code,
              0);
    const json loops = ring.loops();
    ASSERT_EQ(loops.size(), 1u);
    EXPECT_EQ(loops[0]["decision"], "accepted") << loops[0]["reason"];
    EXPECT_EQ(loops[0]["reason"], "named in the .ini");
    EXPECT_EQ(loops[0]["loop"], loop["loop"]) << "the same two scans";
    EXPECT_TRUE(ring.warnings().empty());
}

TEST(RunNamedLoop, that_is_none_is_refused_and_told) {
    const RingProgram ring;
    // The vehicle is in the upper passage then, and was in the lower one.
    const std::string name = "1300000029 - 1300000006";
    const auto said = ring.run_with("named_loops", name);
    EXPECT_EQ(said.exit_code, 0);
    const json loop = ring.loops()[0];
    EXPECT_EQ(loop["decision"], "refused");
    const std::string warning =
        "[grid_slam] named_loops: " + name + " is not closed: " + loop["reason"].get<std::string>();
    EXPECT_EQ(ring.warnings(), std::vector<std::string>{warning});
    EXPECT_EQ(said.err, "loopline: warning: " + warning + "\n");
    EXPECT_EQ(ring.accepted()["reason"], "two matches agree") << "the true loop is found all the same";
}

TEST(RunNamedLoop, of_another_time_is_told) {
    const RingProgram ring;
    EXPECT_EQ(ring.run_with("named_loops", "39.3 - 1.6").exit_code, 0);
    const json loops = ring.loops();
    const json& loop = loops.back();
    EXPECT_EQ(loop["loop"], "39.300000000 - 1.600000000");
    EXPECT_EQ(loop["decision"], "refused");
    ASSERT_EQ(ring.warnings().size(), 1u);
    EXPECT_EQ(ring.warnings()[0],
              "[grid_slam] named_loops: 39.3 - 1.6 is not closed: no scan of the log is of that time (its "
              "scans are "
              "from 1300000000.000000000 to 1300000083.600000000)");
    EXPECT_EQ(ring.run_with("refuse_loops", "39.3").exit_code, 0);
    ASSERT_EQ(ring.warnings().size(), 1u);
    EXPECT_EQ(ring.warnings()[0].find("[grid_slam] 39.3 refuses nothing: no scan of the log is of that time"),
              0u);
}

TEST(RunNamedLoop, that_can_not_be_read_ends_with_2) {
    const RingProgram ring;
    for (const auto& [key, value, told] :
         {std::tuple{"named_loops", "1 - 2",
                     "[grid_slam] named_loops holds \"1 - 2\": the later scan comes first"},
          {"refuse_loops", "first",
           "[grid_slam] refuse_loops holds \"first\", where \"first\" is not a time"},
          {"loops_off", "1", "[grid_slam] loops_off holds \"1\"; an interval is \"from .. to\""}}) {
        const auto said = ring.run_with(key, value);
        EXPECT_EQ(said.exit_code, 2);
        EXPECT_NE(said.err.find(told), std::string::npos) << said.err;
    }
    EXPECT_FALSE(std::filesystem::exists(ring.out("")));
}
