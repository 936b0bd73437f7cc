/// What ${LOOPLINE_DATA} stands for: the environment, the working directory, the source tree; else one
/// sentence.
#include <gtest/gtest.h>

#include "support/run_program.h"

using namespace loopline;

namespace {

/// A copy of the program in a tree of its own: place/tree/build/release/bin/loopline.
class DataFolderTest : public testing::Test {
 protected:
    DataFolderTest() {
        const auto bin = place_ / "tree/build/release/bin";
        std::filesystem::create_directories(bin);
        std::filesystem::copy_file(test::loopline_program(), bin / "loopline");
        std::filesystem::create_directories(place_ / "elsewhere");
        ini_ =
            place_.write("tree/e.ini", "[run]\nmodules = shift\nrawlog = ${LOOPLINE_DATA}/logs/a.rawlog\n");
    }

    /// What `check` complains about the log, which is there nowhere: its path, or why that is not known.
    std::string complaint(const std::string& data_setting, const std::string& folder) {
        const auto result = test::run_program(
            {(place_ / "tree/build/release/bin/loopline").string(), "check", ini_},
            {data_setting, std::string("LOOPLINE_PLUGINS=") + test::fixture_folder() + "/good",
             std::string("LD_LIBRARY_PATH=") + test::plugin_folder()},
            place_ / folder);
        return result.err;
    }
    void expect_log_in(const std::string& folder, const std::string& said) {
        const std::string path = folder + "/logs/a.rawlog\n";
        EXPECT_NE(said.find("not there: " + path), std::string::npos) << said;
    }

    test::TemporaryFolder place_;
    std::string ini_;
};

}  // namespace

TEST_F(DataFolderTest, is_the_environment_first) {
    std::filesystem::create_directories(place_ / "shared/data");
    expect_log_in("/far/away", complaint("LOOPLINE_DATA=/far/away", "tree"));
}

TEST_F(DataFolderTest, is_beside_the_working_directory_next) {
    std::filesystem::create_directories(place_ / "shared/data");
    std::filesystem::create_directories(place_ / "elsewhere/shared/data");
    std::filesystem::create_directories(place_ / "elsewhere/project");
    expect_log_in((place_ / "elsewhere/shared/data").string(),
                  complaint("LOOPLINE_DATA", "elsewhere/project"));
}

TEST_F(DataFolderTest, is_beside_the_source_tree_of_the_program_last) {
    std::filesystem::create_directories(place_ / "shared/data");
    std::filesystem::create_directories(place_ / "elsewhere/project");
    expect_log_in((place_ / "shared/data").string(), complaint("LOOPLINE_DATA", "elsewhere/project"));
}

TEST_F(DataFolderTest, absent_it_is_one_clear_sentence) {
    const std::string said = complaint("LOOPLINE_DATA", "elsewhere");
    EXPECT_NE(said.find("e.ini:3: [run] rawlog needs ${LOOPLINE_DATA}, which is not set"), std::string::npos)
        << said;
    EXPECT_EQ(said.find("names no log"), std::string::npos) << "one sentence is enough: " << said;
}
