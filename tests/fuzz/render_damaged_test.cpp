/// Damaged and hostile maps given to `loopline render`: a picture, or one sentence and exit code 3.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "cli/run_support.h"
#include "output/stored_cloud_files.h"
#include "pipeline/log_file.h"

using namespace loopline;
using namespace loopline::testing;

namespace {

std::string unpacked_map(const std::string& path) {
    LogFile file(path);
    std::string bytes;
    for (char byte = 0; !file.at_end();) bytes.push_back((file.Read(&byte, 1), byte));
    return bytes;
}

class RenderDamaged : public ::testing::Test {
 protected:
    static void SetUpTestSuite() {
        maker_ = std::make_unique<SmallRun>("odometry");
        const auto result =
            maker_->run(telecom_log, {"--set", "outputs.maps=true", "--set", "run.maps=grid simplemap",
                                      "--set", "grid.resolution_m=0.5"});
        ASSERT_EQ(result.exit_code, 0) << result.err;
    }
    static void TearDownTestSuite() { maker_.reset(); }

    std::string intact(const std::string& extension) const {
        for (const auto& entry : std::filesystem::directory_iterator(maker_->out()))
            if (entry.path().extension() == extension) return unpacked_map(entry.path().string());
        ADD_FAILURE() << "no " << extension;
        return {};
    }
    test::ProgramResult render(const std::string& extension, const std::string& bytes) {
        write_file(folder_ / ("hostile" + extension), bytes);
        return test::run_loopline(
            {"render", folder_ / ("hostile" + extension), "--size", "320x240", "--out", picture()});
    }
    void expect_refusal(const test::ProgramResult& result) {
        EXPECT_EQ(result.exit_code, 3) << result.err;
        EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
        expect_sentences(result.err, folder_ / "hostile");
        EXPECT_FALSE(std::filesystem::exists(picture()));
    }
    std::string picture() const { return folder_ / "p.png"; }

    Folder folder_;
    static std::unique_ptr<SmallRun> maker_;
};

std::unique_ptr<SmallRun> RenderDamaged::maker_;

}  // namespace

TEST_F(RenderDamaged, a_truncated_map_is_refused) {
    for (const char* extension : {".gridmap", ".simplemap"}) {
        const std::string bytes = intact(extension);
        EXPECT_EQ(render(extension, bytes).exit_code, 0);
        std::filesystem::remove(picture());
        for (const std::size_t kept : {std::size_t{0}, std::size_t{5}, bytes.size() / 2, bytes.size() - 1})
            expect_refusal(render(extension, bytes.substr(0, kept)));
    }
}

TEST_F(RenderDamaged, flipped_bits_and_absurd_counts_give_a_picture_or_a_sentence) {
    std::mt19937_64 random(21);
    for (const char* extension : {".gridmap", ".simplemap"}) {
        const std::string bytes = intact(extension);
        const std::size_t head = std::min<std::size_t>(bytes.size(), 400);  // sizes and poses stand there
        for (int i = 0; i < 12; ++i) {
            std::string mutant = bytes;
            if (i % 3 == 2)
                mutant.replace(random() % (head - 4), 4,
                               i % 2 == 0 ? "\xff\xff\xff\x7f" : "\xff\xff\xff\xff");
            else
                for (int flip = 0; flip < 4; ++flip)
                    mutant[random() % (i % 3 == 0 ? head : bytes.size())] ^=
                        static_cast<char>(1 << (random() % 8));
            std::filesystem::remove(picture());
            const auto result = render(extension, mutant);
            if (result.exit_code == 0)
                EXPECT_TRUE(std::filesystem::exists(picture()));
            else
                expect_refusal(result);
        }
    }
}

TEST_F(RenderDamaged, a_rawlog_is_no_map) {
    const auto log = file_bytes(telecom_log);
    for (const char* extension : {".gridmap", ".simplemap", ".rawlog"})
        expect_refusal(render(extension, log));
    const std::string mutant = log.substr(0, log.size() / 3);
    write_file(folder_ / "hostile.rawlog", mutant);
    const auto evaluated = test::run_loopline(
        {"evaluate", "--estimate", folder_ / "hostile.rawlog", "--reference", folder_ / "hostile.rawlog"});
    expect_refusal(evaluated);
}

TEST_F(RenderDamaged, a_cloud_with_flipped_bits_gives_a_picture_or_a_sentence_and_one_cut_off_a_sentence) {
    StoredCloud cloud;
    std::mt19937_64 random(5);
    for (int k = 0; k < 11'000; ++k) {
        CloudPoint point;
        for (auto& x : point.place) x = static_cast<std::int32_t>(random() % 400'000);
        cloud.push_back(point);
    }
    write_ply(folder_ / "c.ply", cloud);
    write_pcd(folder_ / "c.pcd", cloud);
    write_las(folder_ / "c.las", cloud);
    for (const std::string extension : {".ply", ".pcd", ".las"}) {
        const std::string bytes = file_bytes(folder_ / ("c" + extension));
        std::filesystem::remove(picture());
        for (const std::size_t kept : {std::size_t{3}, std::size_t{120}, bytes.size() - 1})
            expect_refusal(render(extension, bytes.substr(0, kept)));
        for (int i = 0; i < 5; ++i) {
            std::string mutant = bytes;
            for (int flip = 0; flip < 4; ++flip)
                mutant[random() % 240] ^= static_cast<char>(1 << (random() % 8));
            std::filesystem::remove(picture());
            const auto result = render(extension, mutant);
            if (result.exit_code == 0)
                EXPECT_TRUE(std::filesystem::exists(picture()));
            else
                expect_refusal(result);
        }
    }
}
