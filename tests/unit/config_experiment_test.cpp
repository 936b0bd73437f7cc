/// From an .ini to a bound and checked experiment, and back to an .ini.
#include <gtest/gtest.h>

#include <cstdlib>

#include "config/experiment.h"
#include "config/plugin_loader.h"
#include "config/problems.h"
#include "support/run_program.h"

using namespace loopline;

namespace {

/// The fixtures' plugin, whichever the build's own are.
class ExperimentTest : public testing::Test {
 protected:
    ExperimentTest() {
        load_plugin(test::fixture_folder() + "/good/libchain.so");
        log_ = folder_.write("logs/a b.rawlog", "");
    }
    std::string ini(const std::string& text) { return folder_.write("e.ini", text); }

    test::TemporaryFolder folder_;
    std::string log_;
};

const std::string head = "[run]\nrawlog = logs/a b.rawlog\nmodules = scale shift\nmaps = paper_map\n";

}  // namespace

TEST_F(ExperimentTest, takes_relative_paths_from_the_folder_of_the_ini) {
    const auto experiment = load_experiment(ini(head), {}, {});
    ASSERT_EQ(experiment.run.rawlogs, std::vector<std::string>{log_});
    ASSERT_EQ(experiment.modules.size(), 2u);
    EXPECT_EQ(experiment.modules[0]->info().name, "scale");
    EXPECT_EQ(experiment.modules[1]->info().name, "shift");
    ASSERT_EQ(experiment.map_builders.size(), 1u);
}

TEST_F(ExperimentTest, takes_paths_of_the_command_line_from_the_working_directory) {
    const auto experiment = load_experiment(ini(head), {"scale.extra_files=x;y"}, {"/dev/null"});
    EXPECT_EQ(experiment.run.rawlogs, std::vector<std::string>{"/dev/null"});
    const auto files = experiment.modules[0]->parameters().find("extra_files")->print();
    const auto here = std::filesystem::current_path();
    EXPECT_EQ(files, (here / "x").string() + "; " + (here / "y").string());
}

TEST_F(ExperimentTest, several_logs_are_separated_by_semicolons) {
    folder_.write("c.rawlog", "");
    const auto experiment =
        load_experiment(ini("[run]\nmodules=shift\nrawlog = logs/a b.rawlog ; c.rawlog # both\n"), {}, {});
    EXPECT_EQ(experiment.run.rawlogs, (std::vector<std::string>{log_, (folder_ / "c.rawlog").string()}));
}

TEST_F(ExperimentTest, the_effective_ini_reads_back_to_itself) {
    const auto first = load_experiment(
        ini(head + "seed = 18446744073709551615\n[scale]\ngate_deg = 33.3333333333333333\n"
                   "sigma_range_m = 0.1\nlabel = \"a # b\"\nsensors = one, two\n"
                   "extra_files = p q.txt ; ../r.txt\nmethod = careful\n[outputs]\nmaps = no\n"),
        {"shift.offset_m=1e-300"}, {});
    const auto again = load_experiment(folder_.write("elsewhere/config.ini", first.effective_ini), {}, {});
    EXPECT_EQ(first.effective_ini, again.effective_ini);
    EXPECT_NE(first.effective_ini.find("label = \"a # b\""), std::string::npos);
    EXPECT_NE(first.effective_ini.find("offset_m = 1e-300"), std::string::npos);
    EXPECT_NE(first.effective_ini.find("seed = 18446744073709551615"), std::string::npos);
    EXPECT_NE(first.effective_ini.find("# Gate on the angle. (number in deg, 0 .. 90, default 30)"),
              std::string::npos);
}

TEST_F(ExperimentTest, a_known_module_that_is_not_used_may_have_its_section) {
    const std::string text = "[run]\nrawlog = logs/a b.rawlog\nmodules = scale\n[shift]\noffset_m = 2\n";
    const auto without = load_experiment(ini(text), {}, {});
    EXPECT_EQ(without.effective_ini.find("[shift]"), std::string::npos);
    const auto with = load_experiment(ini(text), {"run.modules=shift"}, {});
    EXPECT_NE(with.effective_ini.find("offset_m = 2"), std::string::npos);
}

TEST_F(ExperimentTest, an_override_stands_in_for_a_value_that_is_wrong) {
    const std::string path = ini(head + "[scale]\nmethod = odd\n[evaluation]\ntruth = nowhere.tum\n");
    EXPECT_THROW(load_experiment(path, {}, {}), ConfigurationError);
    EXPECT_NO_THROW(load_experiment(path, {"scale.method=plain", "evaluation.truth="}, {}));
}

TEST_F(ExperimentTest, a_fresh_map_builder_has_the_values_of_its_pattern) {
    const auto experiment = load_experiment(ini(head + "[paper_map]\ncell_m = 0.1\n"), {}, {});
    const auto fresh = fresh_map_builder(*experiment.map_builders[0]);
    EXPECT_NE(fresh, experiment.map_builders[0]);
    EXPECT_EQ(fresh->parameters().find("cell_m")->print(), "0.1");
}

TEST_F(ExperimentTest, LOOPLINE_DATA_is_the_environment_first) {
    setenv("LOOPLINE_DATA", (folder_ / "logs").c_str(), 1);
    const auto experiment =
        load_experiment(ini("[run]\nmodules=shift\nrawlog = ${LOOPLINE_DATA}/a b.rawlog\n"), {}, {});
    unsetenv("LOOPLINE_DATA");
    EXPECT_EQ(experiment.run.rawlogs.at(0), log_);
}

TEST(AngleParameter, prints_what_it_reads_bit_for_bit) {
    for (const char* text :
         {"30", "0.1", "12.3456789012345", "89.99999999999999", "-33.3333333333333333", "1e-9"}) {
        double first_rad = 0, again_rad = 0;
        ParameterTable first("a", ""), again("a", "");
        first.angle("x_deg", first_rad, Range::any(), "");
        again.angle("x_deg", again_rad, Range::any(), "");
        ASSERT_FALSE(first.find("x_deg")->parse(text));
        ASSERT_FALSE(again.find("x_deg")->parse(first.find("x_deg")->print()));
        EXPECT_EQ(first_rad, again_rad) << text;
    }
    double sixth_rad = M_PI / 6;
    ParameterTable table("a", "");
    table.angle("x_deg", sixth_rad, Range::any(), "");
    EXPECT_EQ(table.find("x_deg")->default_text, "30");
    EXPECT_EQ(sixth_rad, 30 * M_PI / 180) << "the default is what its printed text reads back as";
}

TEST(ParameterTable, ranges_are_written_as_people_write_them) {
    double x = 0;
    int n = 1;
    ParameterTable table("a", "");
    table.real("x", x, {-0.5, 1e-9}, "").integer("n", n, {1, 2e9}, "");
    ParameterTable open("b", "");
    open.real("x", x, Range::positive(), "").integer("n", n, Range::at_least(1), "");
    EXPECT_EQ(table.find("x")->allowed, "-0.5 .. 1e-09");
    EXPECT_EQ(table.find("n")->allowed, "1 .. 2000000000");
    EXPECT_EQ(open.find("x")->allowed, "> 0");
    EXPECT_EQ(open.find("n")->allowed, ">= 1");
}
