/// Lists that lie on disk give back what was put into them, and go on where a checkpoint was made.
#include <gtest/gtest.h>
#include <mrpt/io/CMemoryStream.h>
#include <mrpt/serialization/CArchive.h>

#include <fstream>
#include <random>

#include "api/set_aside.h"
#include "api/state_archive.h"
#include "api/trajectory.h"
#include "pipeline_logs.h"

using namespace loopline;
using namespace loopline::testing;

namespace {

struct Item {
    std::uint64_t number;
    double value;
};
using List = SetAside<Item>;

Item item(std::uint64_t k) {
    return {k, 0.1 * static_cast<double>(k)};
}

void append(List& list, std::uint64_t items) {
    for (std::uint64_t k = 0; k < items; ++k) list.push_back(item(list.size()));
}

void expect_items(const List& list, std::uint64_t items) {
    ASSERT_EQ(list.size(), items);
    std::uint64_t k = 0;
    for (const Item x : list) {
        ASSERT_EQ(x.number, k);
        ASSERT_EQ(x.value, item(k).value);
        ++k;
    }
    ASSERT_EQ(k, items);
}

/// What a checkpoint holds.
class Saved {
 public:
    explicit Saved(List& list, bool everything = false) {
        Whole whole(stream_);
        mrpt::serialization::CArchiveStreamBase<mrpt::io::CMemoryStream> part(stream_);
        StateWriter writer(everything ? static_cast<mrpt::serialization::CArchive&>(whole) : part);
        writer(list);
    }
    void load(List& list) {
        stream_.Seek(0);
        mrpt::serialization::CArchiveStreamBase<mrpt::io::CMemoryStream> archive(stream_);
        StateReader reader(archive);
        reader(list);
    }
    std::uint64_t bytes() { return stream_.getTotalBytesCount(); }

 private:
    struct Whole : mrpt::serialization::CArchiveStreamBase<mrpt::io::CMemoryStream>, HoldsEverything {
        using CArchiveStreamBase::CArchiveStreamBase;
    };
    mrpt::io::CMemoryStream stream_;
};

}  // namespace

TEST(SetAside, gives_back_in_any_order_what_was_appended_and_set) {
    const Folder folder;
    for (const bool on_disk : {true, false}) {
        List list;
        if (on_disk) list.keep_in(folder / "scratch", "list");
        append(list, 20000);
        EXPECT_TRUE(!on_disk || std::filesystem::exists(folder / "scratch/list"));
        expect_items(list, 20000);
        std::mt19937 random(1);
        for (int n = 0; n < 3000; ++n) {
            const std::uint64_t k = random() % list.size();
            ASSERT_EQ(list[k].number, k);
        }
        for (const std::uint64_t k : {0U, 1U, 7777U, 19999U}) list.set(k, {k, -1});
        for (const std::uint64_t k : {0U, 1U, 7777U, 19999U}) EXPECT_EQ(list[k].value, -1);
        for (std::uint64_t k = 2000; k < 7000; ++k) ASSERT_EQ(list[k].number, k);
        EXPECT_EQ(list[7777].value, -1);
        List copy = list;
        copy.set(7777, item(7777));
        EXPECT_EQ(copy[7777].value, item(7777).value);
        List moved = std::move(list);
        EXPECT_EQ(moved[7777].value, -1);
        EXPECT_EQ(moved.size(), 20000u);
        std::uint64_t k = 900;
        moved.for_each(900, 15000, [&](const Item& x) { EXPECT_EQ(x.number, k++); });
        EXPECT_EQ(k, 15000u);
    }
}

TEST(SetAside, stays_in_memory_where_there_can_be_no_file_and_makes_none_for_little) {
    const Folder folder;
    write_file(folder / "file", "no folder");
    List list;
    list.keep_in(folder / "file/scratch", "list");
    append(list, 5000);
    expect_items(list, 5000);
    EXPECT_THROW(Saved{list}, std::exception);
    List little;
    little.keep_in(folder / "scratch", "little");
    append(little, 10);
    expect_items(little, 10);
    EXPECT_FALSE(std::filesystem::exists(folder / "scratch"));
}

TEST(SetAside, goes_on_from_a_checkpoint_that_refers_to_its_file) {
    const Folder folder;
    for (const std::uint64_t items : {0U, 3U, 1024U, 5000U}) {
        std::filesystem::remove_all(folder / "scratch");
        List list;
        list.keep_in(folder / "scratch", "list");
        append(list, items);
        Saved saved(list);
        EXPECT_LT(saved.bytes(), 100u);
        append(list, 4000);  // lost with the process

        List again;
        again.keep_in(folder / "scratch", "list");
        saved.load(again);
        expect_items(again, items);
        for (std::uint64_t k = 0; k < 3000; ++k) again.push_back(item(again.size()));
        expect_items(again, items + 3000);
    }
}

TEST(SetAside, is_not_gone_on_with_where_its_file_has_changed) {
    const Folder folder;
    List list;
    list.keep_in(folder / "scratch", "list");
    append(list, 3000);
    Saved saved(list);
    const std::string whole = file_bytes(folder / "scratch/list");
    const auto loads = [&](const std::string& bytes) {
        write_file(folder / "scratch/list", bytes);
        List again;
        again.keep_in(folder / "scratch", "list");
        try {
            saved.load(again);
        } catch (const std::exception&) {
            return false;
        }
        return true;
    };
    EXPECT_TRUE(loads(whole));
    EXPECT_TRUE(loads(whole + "more"));
    for (const std::size_t at : {std::size_t{0}, whole.size() / 2, whole.size() - 1}) {
        std::string damaged = whole;
        damaged[at] ^= 1;
        EXPECT_FALSE(loads(damaged)) << at;
    }
    EXPECT_FALSE(loads(whole.substr(0, whole.size() - 1)));
    std::filesystem::remove(folder / "scratch/list");
    List again;
    again.keep_in(folder / "scratch", "list");
    EXPECT_THROW(saved.load(again), std::exception);
}

TEST(SetAside, is_all_in_a_state_that_must_hold_everything) {
    const Folder folder;
    List list;
    list.keep_in(folder / "scratch", "list");
    append(list, 3000);
    Saved saved(list, true);
    EXPECT_GT(saved.bytes(), 3000 * sizeof(Item));
    std::filesystem::remove_all(folder / "scratch");
    List again;
    again.keep_in(folder / "other", "list");
    saved.load(again);
    expect_items(again, 3000);
}

TEST(Trajectory, is_the_same_on_disk_and_in_memory) {
    const Folder folder;
    Trajectory in_memory, on_disk;
    on_disk.keep_in(folder / "scratch");
    for (std::uint64_t k = 0; k < 1000; ++k) {
        const double x = 0.1 * static_cast<double>(k);
        Matrix6d covariance = Matrix6d::Zero();
        covariance(0, 0) = x;
        if (k % 7 == 0) covariance(3, 3) = 2 * x + 1;  // not of a planar pose
        for (Trajectory* path : {&in_memory, &on_disk})
            path->append(2 * k, static_cast<StampNs>(1000 * k), Pose3(Pose2{x, -x, 0.01 * x}), covariance);
    }
    for (Trajectory* path : {&in_memory, &on_disk}) {
        path->revise(500, Pose3(Pose2{1, 2, 3}), Matrix6d::Identity());
        path->finish_revision();
    }
    EXPECT_FALSE(std::filesystem::exists(folder / "scratch/unseen"));
    for (std::size_t k = 0; k < 1000; ++k) {
        ASSERT_EQ(on_disk[k].sequence, 2 * k);
        ASSERT_EQ(on_disk[k].covariance.matrix(), in_memory[k].covariance.matrix());
        ASSERT_EQ(on_disk[k].T_map_base.translation_m, in_memory[k].T_map_base.translation_m);
        ASSERT_EQ(on_disk[k].T_map_base.rotation.coeffs(), in_memory[k].T_map_base.rotation.coeffs());
        ASSERT_EQ(on_disk.T_map_base_online(k).translation_m, in_memory.T_map_base_online(k).translation_m);
        ASSERT_EQ(on_disk.find(2 * k)->stamp_ns, static_cast<StampNs>(1000 * k));
        ASSERT_FALSE(on_disk.find(2 * k + 1));
    }
    EXPECT_EQ(on_disk[500].covariance.matrix(), Matrix6d::Identity());
    EXPECT_EQ(on_disk.length_m(), in_memory.length_m());
    EXPECT_EQ(on_disk.pose_at(700500, 3)->translation_m, in_memory.pose_at(700500, 3)->translation_m);
}
