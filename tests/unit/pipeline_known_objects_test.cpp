/// The classes that the host reads itself, against CArchive::ReadObject(): the same objects to the bit, from
/// the same bytes, and nothing from bytes that MRPT refuses.
#include <gtest/gtest.h>
#include <mrpt/io/CFileGZInputStream.h>
#include <mrpt/io/CMemoryStream.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservationComment.h>
#include <mrpt/obs/CObservationOdometry.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <random>

#include "pipeline/archive_reader.h"
#include "pipeline/known_objects.h"
#include "pipeline_logs.h"
#include "support/shared_data.h"

using namespace loopline;
using namespace loopline::testing;
using mrpt::obs::CObservation2DRangeScan;
using mrpt::obs::CObservationOdometry;
using mrpt::serialization::CSerializable;

namespace {

using Bytes = std::vector<unsigned char>;

Bytes bytes_of(const CSerializable& object) {
    mrpt::io::CMemoryStream stream;
    mrpt::serialization::archiveFrom(stream) << object;
    const auto* data = static_cast<const unsigned char*>(stream.getRawBufferData());
    return {data, data + stream.getTotalBytesCount()};
}

/// What MRPT makes of the bytes: an object and how many of them it takes, or null.
std::pair<CSerializable::Ptr, std::size_t> by_mrpt(const Bytes& bytes) {
    mrpt::io::CMemoryStream stream;
    stream.assignMemoryNotOwn(bytes.data(), bytes.size());
    auto archive = mrpt::serialization::archiveFrom(stream);
    try {
        auto object = archive.ReadObject();
        return {object, stream.getPosition()};
    } catch (const std::exception&) {
        return {nullptr, 0};
    }
}

/// Fields that serialisation leaves out are compared too.
void expect_same(const CSerializable& known, const CSerializable& expected) {
    EXPECT_EQ(known.GetRuntimeClass(), expected.GetRuntimeClass());
    EXPECT_EQ(bytes_of(known), bytes_of(expected));
    if (const auto* scan = dynamic_cast<const CObservation2DRangeScan*>(&known)) {
        const auto& other = dynamic_cast<const CObservation2DRangeScan&>(expected);
        for (std::size_t i = 0; i < scan->getScanSize(); ++i)
            ASSERT_EQ(scan->getScanIntensity(i), other.getScanIntensity(i));
        EXPECT_EQ(scan->sensorPose.yaw(), other.sensorPose.yaw());
        EXPECT_EQ(scan->getAuxPointsMap<mrpt::maps::CMetricMap>(), nullptr);
    } else if (const auto* odometry = dynamic_cast<const CObservationOdometry*>(&known)) {
        const auto& other = dynamic_cast<const CObservationOdometry&>(expected);
        EXPECT_EQ(odometry->encoderLeftTicks, other.encoderLeftTicks);
        EXPECT_EQ(odometry->velocityLocal.vx, other.velocityLocal.vx);
        EXPECT_EQ(odometry->odometry.phi_cos(), other.odometry.phi_cos());
    }
}

CObservation2DRangeScan any_scan(std::mt19937_64& random) {
    std::uniform_real_distribution<double> any(-3, 3);
    CObservation2DRangeScan scan;
    const std::size_t beams = 1 + random() % 400;
    scan.resizeScanAndAssign(beams, 0, true);
    for (std::size_t i = 0; i < beams; ++i) {
        scan.setScanRange(i, random() % 50 == 0 ? std::numeric_limits<float>::quiet_NaN()
                                                : static_cast<float>(any(random)));
        scan.setScanRangeValidity(i, random() % 20 != 0);
    }
    scan.aperture = static_cast<float>(any(random));
    scan.rightToLeft = random() % 2 == 0;
    scan.maxRange = static_cast<float>(any(random));
    scan.stdError = static_cast<float>(any(random));
    scan.beamAperture = static_cast<float>(any(random));
    scan.deltaPitch = random() % 2 == 0 ? any(random) : 0;
    if (random() % 3 > 0)
        scan.sensorPose = {any(random), any(random), any(random), any(random), any(random), any(random)};
    scan.sensorLabel = std::string(random() % 30, 'L');
    scan.timestamp = stamp_to_mrpt(static_cast<StampNs>(random() % 2'000'000'000) * 1'000'000'000);
    return scan;
}

CObservationOdometry any_odometry(std::mt19937_64& random) {
    std::uniform_real_distribution<double> any(-10, 10);
    CObservationOdometry odometry;
    odometry.odometry = {any(random), any(random), any(random)};
    odometry.sensorLabel = std::string(random() % 30, 'o');
    odometry.hasEncodersInfo = random() % 2 == 0;
    odometry.encoderLeftTicks = static_cast<int>(random());
    odometry.encoderRightTicks = static_cast<int>(random());
    odometry.hasVelocities = random() % 2 == 0;
    odometry.velocityLocal = {any(random), any(random), any(random)};
    odometry.timestamp = stamp_to_mrpt(static_cast<StampNs>(random() % 2'000'000'000) * 1'000'000'000);
    return odometry;
}

Bytes any_object(std::mt19937_64& random) {
    return random() % 2 == 0 ? bytes_of(any_scan(random)) : bytes_of(any_odometry(random));
}

}  // namespace

TEST(KnownObjects, scans_and_odometry_are_those_that_MRPT_reads) {
    std::mt19937_64 random(1);
    KnownObjects known;
    std::vector<mrpt::obs::CObservation::Ptr> held;  // some are still in use when the next ones are read
    for (int i = 0; i < 500; ++i) {
        const Bytes bytes = any_object(random);
        const auto reading = known.read(bytes.data(), bytes.size());
        ASSERT_TRUE(reading.object) << i;
        EXPECT_EQ(reading.size, bytes.size());
        expect_same(*reading.object, *by_mrpt(bytes).first);
        if (random() % 3 == 0) held.push_back(reading.object);
        if (held.size() > 40) held.clear();
    }
}

TEST(KnownObjects, an_object_in_use_is_left_alone_and_a_free_one_used_again) {
    std::mt19937_64 random(2);
    KnownObjects known;
    const Bytes first = bytes_of(any_scan(random)), second = bytes_of(any_scan(random));
    auto kept = known.read(first.data(), first.size()).object;
    for (int i = 0; i < 50; ++i) known.read(second.data(), second.size());
    EXPECT_EQ(bytes_of(*kept), first);
    const CSerializable* const place = kept.get();
    kept.reset();
    bool again = false;
    for (int i = 0; i < 50; ++i)
        again = again || known.read(second.data(), second.size()).object.get() == place;
    EXPECT_TRUE(again);
}

TEST(KnownObjects, points_drawn_from_a_scan_do_not_stay_for_the_next_one_in_its_place) {
    std::mt19937_64 random(3);
    KnownObjects known;
    for (int i = 0; i < 60; ++i) {
        const Bytes bytes = bytes_of(any_scan(random));
        const auto object = known.read(bytes.data(), bytes.size()).object;
        expect_same(*object, *by_mrpt(bytes).first);
        dynamic_cast<const CObservation2DRangeScan&>(*object)
            .buildAuxPointsMap<mrpt::maps::CSimplePointsMap>();
    }
}

TEST(KnownObjects, as_long_as_bytes_are_missing_it_says_how_many_would_tell) {
    std::mt19937_64 random(4);
    for (int i = 0; i < 40; ++i) {
        KnownObjects known;
        const Bytes bytes = any_object(random);
        std::size_t ready = 0;
        for (int calls = 0;; ++calls) {
            ASSERT_LT(calls, 10);
            const auto reading = known.read(bytes.data(), ready);
            if (reading.object) {
                EXPECT_EQ(reading.size, bytes.size());
                break;
            }
            ASSERT_GT(reading.size, ready) << "no progress";
            // Odometry asks for as much as it can be at most.
            ASSERT_LE(reading.size, bytes.size() + 40) << "asks for more than the object";
            ready = std::min(reading.size, bytes.size());
        }
    }
}

TEST(KnownObjects, what_they_do_not_know_is_left_to_MRPT) {
    KnownObjects known;
    std::mt19937_64 random(5);
    mrpt::obs::CObservationComment comment;
    comment.text = std::string(200, 'c');
    CObservation2DRangeScan with_intensities = any_scan(random);
    with_intensities.setScanHasIntensity(true);
    CObservation2DRangeScan without_beams = any_scan(random);
    without_beams.resizeScan(0);
    for (const CSerializable* object :
         std::initializer_list<const CSerializable*>{&comment, &with_intensities, &without_beams}) {
        const Bytes bytes = bytes_of(*object);
        const auto reading = known.read(bytes.data(), bytes.size());
        EXPECT_FALSE(reading.object);
        EXPECT_LE(reading.size, bytes.size());
    }
}

TEST(KnownObjects, from_damaged_bytes_it_reads_what_MRPT_reads_or_leaves_them_to_it) {
    std::mt19937_64 random(6);
    KnownObjects known;
    int both = 0, left = 0;
    for (int i = 0; i < 4000; ++i) {
        Bytes bytes = any_object(random);
        for (int flips = 1 + static_cast<int>(random() % 3); flips > 0; --flips) {
            // Mostly where numbers of beams, lengths, flags and versions stand, not in the ranges.
            const std::size_t front = std::min<std::size_t>(bytes.size(), 190),
                              back = std::min<std::size_t>(front, 60);
            const std::size_t at = random() % 3 > 0 ? random() % front : bytes.size() - 1 - random() % back;
            bytes[at] =
                static_cast<unsigned char>(random() % 2 == 0 ? random() : bytes[at] ^ (1U << random() % 8));
        }
        if (random() % 4 == 0) bytes.resize(random() % bytes.size());
        const auto reading = known.read(bytes.data(), bytes.size());
        if (!reading.object) {
            ++left;
            continue;
        }
        ++both;
        const auto [expected, size] = by_mrpt(bytes);
        ASSERT_TRUE(expected) << "MRPT refuses this";
        EXPECT_EQ(reading.size, size);
        expect_same(*reading.object, *expected);
    }
    EXPECT_GT(both, 500);
    EXPECT_GT(left, 500);
}

namespace {

/// Object by object, the host's reader beside MRPT's on its own stream; how many there were.
std::size_t compare_readers(const std::string& path) {
    mrpt::io::CFileGZInputStream file(path);
    auto archive = mrpt::serialization::archiveFrom(file);
    ArchiveReader reader(path);
    std::size_t objects = 0;
    while (const auto object = reader.next()) {
        const auto expected = archive.ReadObject();
        EXPECT_EQ(bytes_of(*object), bytes_of(*expected)) << path << ", object " << objects;
        ++objects;
    }
    EXPECT_THROW(archive.ReadObject(), std::exception) << path;
    return objects;
}

}  // namespace

TEST(KnownObjects, the_log_in_observation_format_is_the_same_object_by_object) {
    Folder folder;
    std::mt19937_64 random(7);
    std::vector<CSerializable::Ptr> objects;
    for (int i = 0; i < 3000; ++i) {
        if (i % 3 == 0)
            objects.push_back(std::make_shared<CObservationOdometry>(any_odometry(random)));
        else if (i % 100 == 1)
            objects.push_back(mrpt::obs::CObservationComment::Create());
        else
            objects.push_back(std::make_shared<CObservation2DRangeScan>(any_scan(random)));
    }
    for (const int compression : {0, 1, 9}) {
        write_log(folder / "log", objects, compression);
        EXPECT_EQ(compare_readers(folder / "log"), objects.size());
    }
}

TEST(KnownObjects, logs_at_hand_are_the_same_object_by_object) {
    std::vector<std::filesystem::path> folders = {"/usr/share/mrpt/datasets"};
    if (std::filesystem::exists(loopline::test::shared_data()))
        folders.push_back(loopline::test::shared_data());
    std::size_t logs = 0;
    for (const auto& folder : folders)
        for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
            if (entry.path().extension() != ".rawlog") continue;
            EXPECT_GT(compare_readers(entry.path().string()), 0u) << entry.path();
            ++logs;
        }
    EXPECT_GE(logs, 3u);
}
