/// Poses with times, in the order of a file: a list that may lie on disk.
#pragma once

#include <filesystem>
#include <vector>

#include "api/pose3_record.h"
#include "api/set_aside.h"
#include "api/stamp.h"

namespace loopline {

struct StampedPose {
    StampNs stamp_ns = 0;
    Pose3 T_map_base;
};

class StampedPath {
 public:
    using value_type = StampedPose;
    using const_iterator = IndexIterator<StampedPath>;

    StampedPath() = default;
    StampedPath(const std::vector<StampedPose>& poses) {
        for (const StampedPose& pose : poses) push_back(pose);
    }
    /// Poses from now on go there; they stay in memory if the folder has no name. Only while there are none.
    void keep_in(const std::filesystem::path& folder) { records_.keep_unseen_in(folder); }

    void push_back(const StampedPose& pose) {
        records_.push_back({pose.stamp_ns, Pose3Record(pose.T_map_base)});
    }
    void set_pose(std::size_t index, const Pose3& T_map_base) {
        records_.set(index, {stamp_ns(index), Pose3Record(T_map_base)});
    }
    std::size_t size() const { return records_.size(); }
    bool empty() const { return records_.empty(); }
    StampedPose operator[](std::size_t index) const {
        const Record record = records_[index];
        return {record.stamp_ns, record.T_map_base.pose()};
    }
    StampNs stamp_ns(std::size_t index) const { return records_[index].stamp_ns; }
    const_iterator begin() const { return {*this, 0}; }
    const_iterator end() const { return {*this, size()}; }

 private:
    struct Record {
        StampNs stamp_ns;
        Pose3Record T_map_base;
    };
    SetAside<Record> records_;
};

/// The poses by stamp: themselves, or a copy in memory that is put into `sorted`.
const StampedPath& in_order_of_stamps(const StampedPath& path, StampedPath& sorted);

}  // namespace loopline
