/// Mutants of the real log through the real program: whatever the bytes, it ends by itself, with an exit code
/// that says what happened, within a memory and a time that do not depend on what the bytes claim.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <random>

#include "cli/run_support.h"
#include "pipeline/log_file.h"

using namespace loopline;
using namespace loopline::testing;

namespace {

std::string unpacked(const std::string& path) {
    LogFile file(path);
    std::string bytes;
    for (char byte = 0; !file.at_end();) bytes.push_back((file.Read(&byte, 1), byte));
    return bytes;
}

/// The kinds of damage that were seen to crash MRPT's readers.
std::string mutant(std::string bytes, int kind, std::mt19937_64& random) {
    const auto place = [&] { return static_cast<std::size_t>(random() % (bytes.size() - 4)); };
    switch (kind) {
        case 0: {  // three bytes at random
            for (int i = 0; i < 3; ++i) bytes[place()] = static_cast<char>(random());
            break;
        }
        case 1: {  // some flipped bits
            for (int i = 0; i < 4; ++i) bytes[place()] ^= static_cast<char>(1 << (random() % 8));
            break;
        }
        case 2: {  // a count that is absurd
            const std::uint32_t counts[] = {0xffffffff, 0x7fffffff, 0x80000000, 0x10000000, 0x00ffffff};
            const std::uint32_t count = counts[random() % 5];
            bytes.replace(place(), 4, reinterpret_cast<const char*>(&count), 4);
            break;
        }
        default: {  // a block lost or doubled
            const std::size_t from = place(),
                              size = std::min<std::size_t>(1 + random() % 300, bytes.size() - from);
            if (random() % 2 == 0)
                bytes.erase(from, size);
            else
                bytes.insert(from, bytes.substr(from, size));
        }
    }
    return bytes;
}

void run_mutants(int kind, int count, std::uint64_t seed) {
    const SmallRun small("odometry lines");
    const std::string log = small.folder() / "mutant.rawlog";
    const std::string intact = unpacked(telecom_log);
    std::mt19937_64 random(seed);
    for (int i = 0; i < count; ++i) {
        write_file(log, mutant(intact, kind, random));
        const auto result = small.run(log);
        EXPECT_TRUE(result.exit_code == 0 || result.exit_code == 3 || result.exit_code == 4)
            << "mutant " << i << " of kind " << kind << ": exit code " << result.exit_code << "\n"
            << result.err;
        EXPECT_EQ(result.err.find("internal error"), std::string::npos) << result.err;
        if (result.exit_code == 3) expect_sentences(result.err, log);
    }
}

}  // namespace

TEST(RunHostileLog, random_bytes) {
    run_mutants(0, 30, 11);
}
TEST(RunHostileLog, flipped_bits) {
    run_mutants(1, 30, 12);
}
TEST(RunHostileLog, absurd_counts) {
    run_mutants(2, 30, 13);
}
TEST(RunHostileLog, lost_and_doubled_blocks) {
    run_mutants(3, 20, 14);
}
