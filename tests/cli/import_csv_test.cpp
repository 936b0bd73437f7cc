/// loopline import csv as a user runs it.
#include <gtest/gtest.h>

#include "evaluate/surveyed_truth.h"
#include "output/tum.h"
#include "support/run_program.h"

using namespace loopline;
using namespace loopline::test;

namespace {

class ImportCsv : public ::testing::Test {
 protected:
    ProgramResult import(const std::vector<std::string>& inputs, const std::string& columns) {
        std::vector<std::string> words{"import", "csv"};
        words.insert(words.end(), inputs.begin(), inputs.end());
        for (const auto& word : {std::string("--columns"), columns, std::string("--out"), out})
            if (!word.empty()) words.push_back(word);
        return run_loopline(words);
    }
    TemporaryFolder folder;
    const std::string out = (folder / "out.rawlog").string();
    const std::string wheels = folder.write("log/wheels.csv", "t,l,r\n1,1,1\n2,1,1\n");
    const std::string truth =
        folder.write("log/truth.csv", "t,lat,lon,h,yaw\n1,50,8,100,0\n2,50,8.00001,100,0\n");
    const std::string wheel_section =
        "[wheels]\nkind = wheels\nfile = wheels.csv\ntime = t\nleft = l\nright = r\ntrack_width_m = 1\n";
    const std::string truth_section =
        "[truth]\nkind = reference\nfile = truth.csv\ntime = t\nlatitude = lat in deg\nlongitude = lon in "
        "deg\nheight = h\nyaw = yaw in deg\n";
};

}  // namespace

TEST_F(ImportCsv, a_folder_becomes_a_rawlog_with_its_truth_and_the_same_bytes_each_time) {
    const std::string map = folder.write("map.ini", wheel_section + truth_section);
    const auto result = import({(folder / "log").string()}, map);
    ASSERT_EQ(result.exit_code, 0) << result.err;
    EXPECT_EQ(result.err, "");
    EXPECT_EQ(result.out, out + ": 2 of wheels, 2 true poses, over 1 s\n");
    const auto poses = read_tum(folder / "out.truth.tum");
    ASSERT_EQ(poses.size(), 2u);
    EXPECT_EQ(poses[0].T_map_base.translation_m, Eigen::Vector3d::Zero());
    EXPECT_NEAR(poses[1].T_map_base.translation_m.x(), 0.7170, 1e-3) << "1e-5 deg of longitude at 50 N";
    const auto frame = read_surveyed_truth(folder / "out.truth.csv", "the truth").earth;
    ASSERT_TRUE(frame);
    EXPECT_NEAR(frame->latitude_deg, 50, 1e-12);
    EXPECT_NEAR(frame->height_m, 100, 1e-6);
    const std::string bytes = file_text(out);
    ASSERT_EQ(import({wheels, truth}, map).exit_code, 0) << "files instead of their folder";
    EXPECT_EQ(file_text(out), bytes);
}

TEST_F(ImportCsv, inputs_that_the_map_does_not_name_are_told) {
    const auto result = import({wheels, truth}, folder.write("map.ini", wheel_section));
    EXPECT_EQ(result.exit_code, 0);
    EXPECT_NE(result.err.find("no section of the column map names " + truth + ", so it is not read"),
              std::string::npos)
        << result.err;
    EXPECT_FALSE(std::filesystem::exists(folder / "out.truth.tum"));
}

TEST_F(ImportCsv, what_is_wrong_ends_it_before_anything_is_written) {
    auto result = import({wheels}, "");
    EXPECT_EQ(result.exit_code, 2);
    result = import({wheels}, "huskie");
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_NE(
        result.err.find("--columns huskie is no file, and no column map that comes with the program; did you "
                        "mean \"husky\"?"),
        std::string::npos)
        << result.err;
    const std::string map = folder.write("map.ini", wheel_section + "speed = l\n");
    result = import({wheels}, map);
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_NE(result.err.find(map + ":8: [wheels] speed is not a key of this section"), std::string::npos)
        << result.err;
    result = import({truth}, folder.write("map.ini", wheel_section));
    EXPECT_EQ(result.exit_code, 3) << "the map is right, the input is not";
    EXPECT_NE(
        result.err.find(map + ":3: [wheels] file names wheels.csv, which is neither an input nor in one"),
        std::string::npos)
        << result.err;
    result = import({(folder / "nowhere").string()}, map);
    EXPECT_EQ(result.exit_code, 3);
    EXPECT_FALSE(std::filesystem::exists(out));
}
