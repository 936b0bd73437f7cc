/// Which pose of the reference belongs to which pose of the estimate.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "output/tum.h"

namespace loopline {

struct PosePair {
    StampNs stamp_ns = 0;            ///< of the estimate
    std::size_t estimate_index = 0;  ///< in the order of its file
    Pose3 T_map_base_estimate;
    Pose3 T_ref_base_reference;
};

/// The poses of a point of the vehicle at `point_m` in base, ahead and left.
std::vector<StampedPose> way_of_point(std::vector<StampedPose> poses, const Eigen::Vector2d& point_m);

/// Every pose of the estimate, in its own order, with the reference pose whose stamp is nearest to its own;
/// left out if that is farther than `max_difference_s`. Either may have stamps that go backwards. Several
/// poses may share one reference pose.
std::vector<PosePair> associate_by_stamp(const std::vector<StampedPose>& estimate,
                                         const std::vector<StampedPose>& reference, double max_difference_s);

/// The same, for a reference of positions alone (of a tracker, say, with a clock of its own rate): each is
/// interpolated between the two reference poses around the estimate's stamp, where there are two and neither
/// is farther than ten times `max_difference_s`.
std::vector<PosePair> associate_positions(const std::vector<StampedPose>& estimate,
                                          const std::vector<StampedPose>& reference, double max_difference_s);

/// What the two above look up: the reference at one time after the other, quick for times in order.
class ReferencePoses {
 public:
    enum class Kind {
        poses,          ///< that whose stamp is nearest
        poses_between,  ///< interpolated between the two around the time, if both are near enough to it; else
                        ///< the nearest
        positions       ///< positions, interpolated over up to ten times that difference
    };
    /// `reference` outlives this.
    ReferencePoses(const StampedPath& reference, double max_difference_s, Kind kind);
    std::optional<Pose3> at(StampNs stamp_ns);

 private:
    std::size_t not_before(StampNs stamp_ns) const;

    StampedPath sorted_;
    const StampedPath* poses_;
    double max_difference_s_;
    Kind kind_;
    std::size_t after_ = 0;  ///< index of the first pose that is not before the latest time
};

/// Pairs in a list that may lie on disk.
class PosePairs {
 public:
    using value_type = PosePair;
    using const_iterator = IndexIterator<PosePairs>;
    /// Pairs from now on go there; they stay in memory if the folder has no name. Only while there are none.
    void keep_in(const std::filesystem::path& folder) { records_.keep_unseen_in(folder); }
    void push_back(const PosePair& pair) {
        records_.push_back({pair.stamp_ns, pair.estimate_index, Pose3Record(pair.T_map_base_estimate),
                            Pose3Record(pair.T_ref_base_reference)});
    }
    std::size_t size() const { return records_.size(); }
    bool empty() const { return records_.empty(); }
    PosePair operator[](std::size_t index) const {
        const Record record = records_[index];
        return {record.stamp_ns, record.estimate_index, record.T_map_base_estimate.pose(),
                record.T_ref_base_reference.pose()};
    }
    const_iterator begin() const { return {*this, 0}; }
    const_iterator end() const { return {*this, size()}; }

 private:
    struct Record {
        StampNs stamp_ns;
        std::uint64_t estimate_index;
        Pose3Record T_map_base_estimate, T_ref_base_reference;
    };
    SetAside<Record> records_;
};

/// First with first, and so on, as long as both have poses.
std::vector<PosePair> associate_by_index(const std::vector<StampedPose>& estimate,
                                         const std::vector<StampedPose>& reference);

}  // namespace loopline
