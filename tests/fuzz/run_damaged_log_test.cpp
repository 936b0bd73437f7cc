/// Logs that can't be read, or not to their end: one sentence, exit code 3, and what was read is kept.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <iostream>

#include "cli/run_support.h"
#include "pipeline/log_file.h"
#include "support/privileges.h"

using namespace loopline;
using namespace loopline::testing;

namespace {

void expect_refused(const SmallRun& small, const std::string& log, const std::string& words) {
    const auto result = small.run(log);
    EXPECT_EQ(result.exit_code, 3) << result.err;
    EXPECT_NE(result.err.find(words), std::string::npos) << result.err;
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
    EXPECT_EQ(result.out, "");
    expect_sentences(result.err, log);
    EXPECT_FALSE(std::filesystem::exists(small.out())) << "nothing could be read, so nothing is written";
}

}  // namespace

TEST(RunDamagedLog, a_log_that_is_not_there_or_is_none) {
    const SmallRun small;
    const Folder& folder = small.folder();
    expect_refused(small, folder / "nowhere.rawlog", "not there");
    expect_refused(small, folder.path().string(), "folder");
    write_file(folder / "empty.rawlog", "");
    expect_refused(small, folder / "empty.rawlog", "empty");
    write_file(folder / "junk.rawlog", "Dear reader, this is no rawlog at all, but a letter.\n");
    expect_refused(small, folder / "junk.rawlog", "not a rawlog");
    write_file(folder / "stub.rawlog", file_bytes(telecom_log).substr(0, 10));
    expect_refused(small, folder / "stub.rawlog", "cut short");
    write_log(folder / "hollow.rawlog", {});
    expect_refused(small, folder / "hollow.rawlog", "no object");
}

TEST(RunDamagedLog, a_log_that_may_not_be_read) {
    const SmallRun small;
    const std::string log = small.folder() / "locked.rawlog";
    write_log(log, drive(3));
    ::chmod(log.c_str(), 0);
    const auto run_as_anybody = [&] {
        if (!test::obey_file_modes()) std::_Exit(1);
        const auto result = small.run(log);
        std::cerr << result.err << result.out;
        std::_Exit(result.exit_code);
    };
    EXPECT_EXIT(run_as_anybody(), ::testing::ExitedWithCode(3),
                "^loopline: [^\n]*/locked.rawlog[^\n]*Permission denied[^\n]*\n$");
    EXPECT_FALSE(std::filesystem::exists(small.out())) << "nothing could be read, so nothing is written";
}

TEST(RunDamagedLog, a_cut_log_gives_the_beginning_of_the_whole_ones_result) {
    const SmallRun small;
    const std::string log = small.folder() / "cut.rawlog";
    ASSERT_EQ(small.run(telecom_log).exit_code, 0);
    const auto whole = small.text_of("trajectory.tum"), bytes = file_bytes(telecom_log);
    std::size_t before = 0;
    for (const std::size_t percent : {2, 10, 35, 60, 85, 99}) {
        write_file(log, bytes.substr(0, bytes.size() * percent / 100));
        const auto result = small.run(log);
        EXPECT_EQ(result.exit_code, 3) << percent;
        EXPECT_NE(result.err.find("cut short in object"), std::string::npos) << result.err;
        expect_sentences(result.err, log);
        EXPECT_EQ(small.metrics()["status"], "damaged_input");
        const auto part = small.text_of("trajectory.tum");
        EXPECT_EQ(part, whole.substr(0, part.size())) << percent;
        EXPECT_GT(part.size(), before);
        before = part.size();
    }
    EXPECT_LT(before, whole.size());
}

TEST(RunDamagedLog, an_unknown_class_is_named_and_what_is_before_it_kept) {
    const SmallRun small;
    const std::string log = small.folder() / "unknown.rawlog";
    write_log(log, drive(10), 0);
    LogFile unpacked(log);
    std::string plain;
    for (char byte = 0; !unpacked.at_end();) plain.push_back((unpacked.Read(&byte, 1), byte));
    const std::string name = "CObservation2DRangeScan", other = "CObservationOfTheMoonXY";
    plain.replace(plain.rfind(name), name.size(), other);
    write_file(log, plain);
    const auto result = small.run(log);
    EXPECT_EQ(result.exit_code, 3);
    EXPECT_NE(result.err.find(other), std::string::npos) << result.err;
    EXPECT_NE(result.err.find("plugin"), std::string::npos) << result.err;
    expect_sentences(result.err, log);
    EXPECT_EQ(small.rows_of_trajectory(), 9u);
}

TEST(RunDamagedLog, a_wrong_checksum_is_told) {
    const SmallRun small;
    const std::string log = small.folder() / "crc.rawlog";
    auto bytes = file_bytes(telecom_log);
    bytes[bytes.size() - 7] ^= 4;
    write_file(log, bytes);
    const auto result = small.run(log);
    EXPECT_EQ(result.exit_code, 3);
    EXPECT_NE(result.err.find("checksum"), std::string::npos) << result.err;
    EXPECT_EQ(small.metrics()["status"], "damaged_input");
    EXPECT_EQ(small.rows_of_trajectory(), 225u) << "all of it is processed all the same";
}

TEST(RunDamagedLog, the_second_of_two_logs_may_be_damaged) {
    const SmallRun small;
    const std::string log = small.folder() / "cut.rawlog";
    const auto bytes = file_bytes(telecom_log);
    write_file(log, bytes.substr(0, bytes.size() / 2));
    const auto result = small.run(telecom_log, {"--rawlog", log});
    EXPECT_EQ(result.exit_code, 3);
    expect_sentences(result.err, log);
    EXPECT_GT(small.rows_of_trajectory(), 225u);
}
