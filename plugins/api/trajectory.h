/// The estimated path as a first-class value: what was known at the time, and what is known now.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>

#include "api/pose3.h"
#include "api/pose3_record.h"
#include "api/pose_covariance.h"
#include "api/set_aside.h"
#include "api/stamp.h"

namespace loopline {

/// One pose of a trajectory. Covariances are of (x y z roll pitch yaw), in m and rad, MRPT's order for a
/// CPose3DPDF being (x y z yaw pitch roll): convert at the boundary only.
struct TrajectoryEntry {
    std::uint64_t sequence =
        0;  ///< of the observation that this pose belongs to (its place in the merged log)
    StampNs stamp_ns = 0;
    Pose3 T_map_base;           ///< the latest revision
    PoseCovariance covariance;  ///< of the latest revision
};

/// Poses in log order. In some logs stamps go backwards while file order is right, so `sequence` is the key
/// and the stamp only serves for interpolation between neighbours in that order.
class Trajectory {
 public:
    using value_type = TrajectoryEntry;
    /// Its entries in order; each is put together when it is asked for.
    class Entries {
     public:
        using const_iterator = IndexIterator<Trajectory>;
        explicit Entries(const Trajectory& trajectory) : trajectory_(&trajectory) {}
        TrajectoryEntry operator[](std::size_t index) const { return (*trajectory_)[index]; }
        std::size_t size() const { return trajectory_->size(); }
        TrajectoryEntry front() const { return (*this)[0]; }
        TrajectoryEntry back() const { return (*this)[size() - 1]; }
        const_iterator begin() const { return {*trajectory_, 0}; }
        const_iterator end() const { return {*trajectory_, size()}; }

     private:
        const Trajectory* trajectory_;
    };

    /// From now on poses lie on disk, in a folder that may still have to be made; in memory if it has no
    /// name. Only while there are none.
    void keep_in(const std::filesystem::path& folder) { records_.keep_unseen_in(folder); }
    /// Adds a pose for a later observation than the last one. Online and latest estimate are the same at
    /// first.
    void append(std::uint64_t sequence, StampNs stamp_ns, const Pose3& T_map_base,
                const PoseCovariance& covariance);
    /// One whose latest estimate is known by now; finish_revision() after the last of them.
    void append_revised(std::uint64_t sequence, StampNs stamp_ns, const Pose3& T_map_base_online,
                        const Pose3& T_map_base, const PoseCovariance& covariance);

    /// Replaces the last entry, its online estimate too: what was known at the time is known only now.
    void replace_last(const Pose3& T_map_base, const PoseCovariance& covariance);

    /// Replaces the latest estimate of entry `index` (smoothing, loop closing); the online one stays.
    /// Call `finish_revision()` after the last of a batch.
    void revise(std::size_t index, const Pose3& T_map_base, const PoseCovariance& covariance);
    void finish_revision() { ++revision_; }
    /// Counts the batches of revisions, so that a map builder knows that it has to draw again.
    std::uint64_t revision() const { return revision_; }

    /// Poses before entry `index` were not known at their time: a start that was found later tells them.
    void set_known_from(std::size_t index) { known_from_ = index; }
    std::size_t known_from() const { return known_from_; }

    Entries entries() const { return Entries(*this); }
    TrajectoryEntry operator[](std::size_t index) const;
    /// What was known at the time of entry `index`, before any later revision.
    Pose3 T_map_base_online(std::size_t index) const;
    bool empty() const { return size() == 0; }
    std::size_t size() const { return records_.size(); }

    /// The entry of an observation; `nullopt` if that observation has no pose.
    std::optional<TrajectoryEntry> find(std::uint64_t sequence) const;

    /// The entry that encloses a time together with the next one (or alone, if it is the last), nearest to
    /// `hint_sequence`; `nullopt` outside of the trajectory.
    std::optional<std::size_t> enclosing(StampNs stamp_ns, std::uint64_t hint_sequence) const;

    /// Latest pose at a time, interpolated at constant twist between the two neighbours of enclosing();
    /// `nullopt` outside of the trajectory. For many times one after the other: PathSampler.
    std::optional<Pose3> pose_at(StampNs stamp_ns, std::uint64_t hint_sequence) const;

    /// Length of the latest path, in metres.
    double length_m() const;

 private:
    /// An entry as it lies on disk.
    struct Record {
        std::uint64_t sequence = 0;
        StampNs stamp_ns = 0;
        Pose3Record T_map_base, T_map_base_online;
        double covariance[9] = {};  ///< of (x y yaw), unless all of it is in spatial_
    };
    void set_covariance(std::size_t index, const PoseCovariance& covariance, Record& record);
    /// Index of the first entry whose sequence is not less.
    std::size_t not_before(std::uint64_t sequence) const;

    SetAside<Record> records_;
    std::map<std::size_t, PoseCovariance> spatial_;  ///< covariances that are not planar, by index
    std::uint64_t revision_ = 0;
    std::size_t known_from_ = 0;
};

}  // namespace loopline
