/// How a log ends: each kind of damage told apart, with everything before it delivered.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <iostream>
#include <random>

#include "commands/command.h"
#include "pipeline/archive_reader.h"
#include "pipeline/file_hash.h"
#include "pipeline_logs.h"
#include "support/privileges.h"

using namespace loopline;
using namespace loopline::testing;

namespace {

struct Reading {
    std::uint64_t objects = 0;
    LogEnd ending = LogEnd::not_yet;
    std::string damage;
};

Reading read_all(const std::string& path, const ReadingRules& rules = {}) {
    ArchiveReader reader(path, rules);
    Reading reading;
    while (reader.next()) ++reading.objects;
    EXPECT_EQ(reading.objects, reader.objects());
    reading.ending = reader.ending();
    reading.damage = reader.damage();
    return reading;
}

void expect_one_sentence(const std::string& sentence, const std::string& path) {
    EXPECT_EQ(sentence.rfind(path, 0), 0u) << sentence;
    EXPECT_EQ(sentence.find('\n'), std::string::npos) << sentence;
    EXPECT_EQ(sentence.find(".cpp"), std::string::npos) << sentence;
}

std::string refusal_to_open(const std::string& path) {
    try {
        ArchiveReader reader(path);
    } catch (const CommandError& e) {
        EXPECT_EQ(e.code(), exit_input_data);
        expect_one_sentence(e.what(), path);
        return e.what();
    }
    ADD_FAILURE() << path << " was opened";
    return {};
}

std::vector<mrpt::serialization::CSerializable::Ptr> some_scans(int count) {
    std::vector<mrpt::serialization::CSerializable::Ptr> scans;
    for (int i = 0; i < count; ++i)
        scans.push_back(scan(1'000'000'000 + i * 100'000'000LL, "LASER", 50, 1.0F + 0.01F * i));
    return scans;
}

}  // namespace

TEST(ArchiveReader, reads_plain_gzip_and_several_gzip_members_to_a_clean_end) {
    Folder folder;
    for (const int compression : {0, 1, 9}) {
        write_log(folder / "log", some_scans(30), compression);
        const auto reading = read_all(folder / "log");
        EXPECT_EQ(reading.objects, 30u);
        EXPECT_EQ(reading.ending, LogEnd::clean);
        EXPECT_EQ(reading.damage, "");
    }
    const auto one = file_bytes(folder / "log");
    write_file(folder / "two", one + one);
    EXPECT_EQ(read_all(folder / "two").objects, 60u);
    EXPECT_EQ(read_all(folder / "two").ending, LogEnd::clean);
    write_file(folder / "padded", one + std::string(100, '\0'));
    EXPECT_EQ(read_all(folder / "padded").ending, LogEnd::clean);

    mrpt::io::CFileGZOutputStream raw;  // no gzip header at all
    std::string plain;
    {
        LogFile unpacked(folder / "log");
        char byte = 0;
        while (!unpacked.at_end()) plain.push_back((unpacked.Read(&byte, 1), byte));
    }
    write_file(folder / "plain", plain);
    EXPECT_EQ(read_all(folder / "plain").objects, 30u);
    EXPECT_EQ(read_all(folder / "plain").ending, LogEnd::clean);
}

TEST(ArchiveReader, a_log_cut_anywhere_keeps_what_is_before_the_cut) {
    Folder folder;
    write_log(folder / "log", some_scans(40), 6);
    const auto whole = file_bytes(folder / "log");
    std::uint64_t before = 0;
    for (std::size_t size = 1; size < whole.size(); size += 11) {
        write_file(folder / "cut", whole.substr(0, size));
        const auto reading = read_all(folder / "cut");
        EXPECT_TRUE(reading.ending == LogEnd::cut_short || (size < 2 && reading.ending != LogEnd::clean))
            << size;
        EXPECT_GE(reading.objects, before) << "more bytes, fewer objects";
        before = reading.objects;
        expect_one_sentence(reading.damage, folder / "cut");
    }
    EXPECT_GE(before, 39u);
}

TEST(ArchiveReader, a_plain_log_cut_between_objects_ends_cleanly_and_inside_one_does_not) {
    Folder folder;
    write_log(folder / "one", some_scans(1));
    LogFile unpacked(folder / "one");
    std::string object;
    for (char byte = 0; !unpacked.at_end();) object.push_back((unpacked.Read(&byte, 1), byte));
    write_file(folder / "two", object + object);
    EXPECT_EQ(read_all(folder / "two").ending, LogEnd::clean);
    for (std::size_t size = 1; size < object.size(); size += 3) {
        write_file(folder / "cut", object + object.substr(0, size));
        const auto reading = read_all(folder / "cut");
        EXPECT_EQ(reading.objects, 1u);
        EXPECT_EQ(reading.ending, LogEnd::cut_short) << size;
    }
}

TEST(ArchiveReader, a_wrong_gzip_checksum_is_told_although_everything_parses) {
    Folder folder;
    write_log(folder / "log", some_scans(40), 6);
    auto bytes = file_bytes(folder / "log");
    bytes[bytes.size() - 6] ^= 1;  // the trailer: 4 bytes of CRC-32, 4 of length
    write_file(folder / "crc", bytes);
    const auto reading = read_all(folder / "crc");
    EXPECT_EQ(reading.objects, 40u);
    EXPECT_EQ(reading.ending, LogEnd::checksum);
    expect_one_sentence(reading.damage, folder / "crc");
}

TEST(ArchiveReader, no_flipped_byte_of_a_gzip_log_passes_silently) {
    Folder folder;
    write_log(folder / "log", some_scans(40), 6);
    const auto whole = file_bytes(folder / "log");
    std::mt19937_64 random(7);
    for (int i = 0; i < 12; ++i) {
        auto bytes = whole;
        const auto at =
            10 + random() % (bytes.size() - 10);  // behind the header, whose name and time mean nothing
        bytes[at] = static_cast<char>(bytes[at] ^ (1 + random() % 255));
        write_file(folder / "flipped", bytes);
        EXPECT_TRUE(holds_or_crashes([&] {
            const auto reading = read_all(folder / "flipped");
            return reading.ending != LogEnd::clean && reading.damage.rfind(folder / "flipped", 0) == 0;
        })) << at;
    }
}

TEST(ArchiveReader, junk_empty_and_hollow_files_are_told_apart) {
    Folder folder;
    write_file(folder / "empty", "");
    EXPECT_EQ(read_all(folder / "empty").ending, LogEnd::empty);
    EXPECT_NE(read_all(folder / "empty").damage.find("empty"), std::string::npos);
    write_log(folder / "hollow", {});
    EXPECT_EQ(read_all(folder / "hollow").ending, LogEnd::empty);
    write_file(folder / "text", "This is a text file, and a long one, that somebody took for a rawlog.\n");
    EXPECT_EQ(read_all(folder / "text").ending, LogEnd::junk);
    write_file(folder / "zeros", std::string(5000, '\0'));
    EXPECT_EQ(read_all(folder / "zeros").ending, LogEnd::junk);
    for (const char* name : {"empty", "hollow", "text", "zeros"})
        expect_one_sentence(read_all(folder / name).damage, folder / name);
}

TEST(ArchiveReader, an_unknown_class_is_named) {
    Folder folder;
    write_log(folder / "log", some_scans(3), 1);
    std::string plain;
    LogFile unpacked(folder / "log");
    for (char byte = 0; !unpacked.at_end();) plain.push_back((unpacked.Read(&byte, 1), byte));
    const std::string name = "CObservation2DRangeScan", other = "CObservationOfTheMoonXY";
    ASSERT_EQ(name.size(), other.size());
    const auto third = plain.rfind(name);
    ASSERT_NE(third, std::string::npos);
    write_file(folder / "unknown", plain.replace(third, name.size(), other));
    const auto reading = read_all(folder / "unknown");
    EXPECT_EQ(reading.objects, 2u);
    EXPECT_EQ(reading.ending, LogEnd::unknown_class);
    EXPECT_NE(reading.damage.find(other), std::string::npos) << reading.damage;
    EXPECT_NE(reading.damage.find("plugin"), std::string::npos) << reading.damage;
    expect_one_sentence(reading.damage, folder / "unknown");
}

TEST(ArchiveReader, what_can_not_be_opened_is_refused_with_its_reason) {
    Folder folder;
    EXPECT_NE(refusal_to_open(folder / "nowhere.rawlog").find("no such"), std::string::npos);
    EXPECT_NE(refusal_to_open(folder.path().string()).find("directory"), std::string::npos);
    ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
    EXPECT_NE(refusal_to_open(folder / "pipe").find("regular"), std::string::npos);
}

TEST(ArchiveReader, what_may_not_be_read_is_refused_with_its_reason) {
    Folder folder;
    write_log(folder / "locked", some_scans(1));
    ::chmod((folder / "locked").c_str(), 0);
    const auto open_as_anybody = [&folder] {
        if (!test::obey_file_modes()) std::_Exit(1);
        std::cerr << refusal_to_open(folder / "locked");
        std::_Exit(0);
    };
    EXPECT_EXIT(open_as_anybody(), ::testing::ExitedWithCode(0), "Permission denied");
}

TEST(ArchiveReader, stops_where_an_earlier_attempt_failed) {
    Folder folder;
    write_log(folder / "log", some_scans(10));
    ReadingRules rules;
    rules.limits = {ReadLimit{4, "it crashes the reader"}};
    const auto reading = read_all(folder / "log", rules);
    EXPECT_EQ(reading.objects, 4u);
    EXPECT_EQ(reading.ending, LogEnd::damaged);
    EXPECT_NE(reading.damage.find("object 5 (it crashes the reader)"), std::string::npos) << reading.damage;
}

TEST(ArchiveReader, the_real_log_ends_cleanly) {
    const auto reading = read_all(telecom_log);
    EXPECT_EQ(reading.ending, LogEnd::clean);
    EXPECT_EQ(reading.objects, 449u) << "225 frames with an action between each two";
}

TEST(FileHash, is_sha_256) {
    Folder folder;
    write_file(folder / "abc", "abc");  // FIPS 180-2, appendix B.1
    EXPECT_EQ(sha256_of_file(folder / "abc"),
              "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    EXPECT_EQ(sha256_of_file(folder / "nowhere"), "");
}
