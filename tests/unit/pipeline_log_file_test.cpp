/// The bytes of a log: quick unpacking gives the same ones as zlib, and so do the ways in which a file is
/// wrong.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>
#include <zlib.h>

#include <map>
#include <random>

#include "pipeline/log_file.h"
#include "pipeline_logs.h"

using namespace loopline;
using namespace loopline::testing;

namespace {

std::string packed(const std::string& bytes, int level, int strategy = Z_DEFAULT_STRATEGY) {
    z_stream deflater{};
    EXPECT_EQ(deflateInit2(&deflater, level, Z_DEFLATED, 15 + 16, 8, strategy), Z_OK);
    std::string result(deflateBound(&deflater, bytes.size()), 0);
    deflater.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
    deflater.avail_in = static_cast<uInt>(bytes.size());
    deflater.next_out = reinterpret_cast<Bytef*>(result.data());
    deflater.avail_out = static_cast<uInt>(result.size());
    EXPECT_EQ(deflate(&deflater, Z_FINISH), Z_STREAM_END);
    result.resize(deflater.total_out);
    deflateEnd(&deflater);
    return result;
}

/// Some of it repeats itself, some does not.
std::string any_bytes(std::size_t size, std::mt19937_64& random) {
    std::string bytes;
    while (bytes.size() < size) {
        const std::size_t back = random() % 3000, part = 1 + random() % 200;
        for (std::size_t i = 0; i < part; ++i)
            bytes.push_back(back < bytes.size() && random() % 8 > 0 ? bytes[bytes.size() - 1 - back]
                                                                    : static_cast<char>(random()));
    }
    bytes.resize(size);
    return bytes;
}

struct Unpacked {
    std::string bytes;
    LogFile::Failure failure = LogFile::Failure::none;
};

Unpacked by_log_file(const std::string& path, std::size_t ahead = 0) {
    LogFile file(path);
    Unpacked reading;
    while (!file.at_end()) {
        const std::size_t size = file.look_ahead(ahead);
        reading.bytes.append(reinterpret_cast<const char*>(file.ready()), size);
        file.skip(size);
    }
    reading.failure = file.failure();
    return reading;
}

Unpacked by_zlib(const std::string& path) {
    const int descriptor = ::open(path.c_str(), O_RDONLY);
    FilePieces file(descriptor);
    file.fill();
    const auto unpacker = make_zlib_unpacker(file);
    Unpacked reading;
    std::vector<unsigned char> buffer(10'000);
    for (auto status = GzipUnpacker::Status::more; status == GzipUnpacker::Status::more;) {
        std::size_t size = 0;
        status = unpacker->unpack(buffer.data(), buffer.size(), size);
        reading.bytes.append(reinterpret_cast<const char*>(buffer.data()), size);
        reading.failure = status == GzipUnpacker::Status::cut_short      ? LogFile::Failure::cut_short
                          : status == GzipUnpacker::Status::bad_data     ? LogFile::Failure::bad_data
                          : status == GzipUnpacker::Status::bad_checksum ? LogFile::Failure::bad_checksum
                          : status == GzipUnpacker::Status::io_error     ? LogFile::Failure::io_error
                                                                         : LogFile::Failure::none;
    }
    ::close(descriptor);
    return reading;
}

}  // namespace

TEST(LogFile, unpacks_what_zlib_packed) {
    Folder folder;
    std::mt19937_64 random(1);
    for (const std::size_t size :
         {std::size_t{1}, std::size_t{1000}, std::size_t{262144}, std::size_t{1'000'000}})
        for (const int level : {0, 1, 6, 9})
            for (const int strategy : {Z_DEFAULT_STRATEGY, Z_HUFFMAN_ONLY, Z_FIXED}) {
                const std::string bytes = any_bytes(size, random);
                write_file(folder / "packed", packed(bytes, level, strategy));
                const auto reading = by_log_file(folder / "packed");
                EXPECT_TRUE(reading.bytes == bytes) << size << " bytes, level " << level;
                EXPECT_EQ(reading.failure, LogFile::Failure::none);
            }
}

TEST(LogFile, goes_through_members_up_to_padding) {
    Folder folder;
    std::mt19937_64 random(2);
    std::string all, file;
    for (int member = 0; member < 40; ++member) {
        const std::string bytes = any_bytes(random() % 40'000, random);
        all += bytes;
        file += packed(bytes, 1 + member % 9);
    }
    for (const std::string& padding :
         {std::string(), std::string(1, '\x1f'), std::string(1000, '\0'), std::string("ab")}) {
        write_file(folder / "packed", file + padding);
        const auto reading = by_log_file(folder / "packed");
        EXPECT_TRUE(reading.bytes == all);
        EXPECT_EQ(reading.failure, LogFile::Failure::none);
    }
}

TEST(LogFile, a_damaged_file_gives_the_bytes_and_the_failure_that_zlib_gives) {
    Folder folder;
    std::mt19937_64 random(3);
    const std::string first = packed(any_bytes(300'000, random), 6),
                      second = packed(any_bytes(50'000, random), 1);
    const std::string whole = first + second;
    std::map<LogFile::Failure, int> failures;
    for (int i = 0; i < 150; ++i) {
        std::string file = whole;
        if (i % 3 == 0)
            file.resize(1 + random() % file.size());
        else
            file[random() % file.size()] ^= static_cast<char>(1 << random() % 8);
        if (i % 10 == 2)
            file = whole, file[12 + random() % 20] ^= 0x55;  // where a block says how it is packed
        if (i % 10 == 1) file = whole, file[file.size() - 1 - random() % 8] ^= 4;
        write_file(folder / "damaged", file);
        const auto expected = by_zlib(folder / "damaged"), reading = by_log_file(folder / "damaged");
        EXPECT_EQ(reading.failure, expected.failure) << i;
        EXPECT_EQ(reading.bytes.size(), expected.bytes.size()) << i;
        EXPECT_TRUE(reading.bytes == expected.bytes) << i;
        ++failures[reading.failure];
    }
    for (const auto failure :
         {LogFile::Failure::cut_short, LogFile::Failure::bad_data, LogFile::Failure::bad_checksum})
        EXPECT_GT(failures[failure], 5);
}

TEST(LogFile, looking_ahead_takes_nothing_and_ends_with_the_file) {
    Folder folder;
    std::mt19937_64 random(4);
    const std::string bytes = any_bytes(700'000, random);
    for (const bool gzip : {false, true}) {
        write_file(folder / "log", gzip ? packed(bytes, 1) : "plain" + bytes.substr(5));
        const std::string expected = gzip ? bytes : "plain" + bytes.substr(5);
        LogFile file(folder / "log");
        std::string read;
        while (!file.at_end()) {
            const std::size_t wanted = random() % 5000, left = expected.size() - read.size();
            const std::size_t ready = file.look_ahead(wanted);
            ASSERT_GE(ready, std::min(wanted, left));
            ASSERT_TRUE(expected.compare(read.size(), ready, reinterpret_cast<const char*>(file.ready()),
                                         ready) == 0);
            if (random() % 2 == 0) {
                std::string part(std::min<std::size_t>(random() % 3000, left), 0);
                file.Read(part.data(), part.size());
                read += part;
            } else {
                const std::size_t part = random() % (ready + 1);
                read.append(reinterpret_cast<const char*>(file.ready()), part);
                file.skip(part);
            }
        }
        EXPECT_TRUE(read == expected);
        EXPECT_EQ(file.failure(), LogFile::Failure::none);
        EXPECT_EQ(file.look_ahead(1), 0U);
        EXPECT_EQ(file.failure(), LogFile::Failure::none) << "nothing was missing, only looked for";
    }
    LogFile file(folder / "log");
    EXPECT_LT(file.look_ahead(bytes.size()), bytes.size()) << "no more than a buffer holds";
}
