/// The path of all sweeps in the finished map. Where the place was found after some sweeps only, theirs are
/// laid out backwards from there; where it had been known before, from both ends.
#pragma once

#include <array>

#include "api/pose3_record.h"
#include "api/set_aside.h"
#include "api/stamp.h"
#include "api/trajectory.h"
#include "cloud_localisation/cloud_localisation.h"

namespace loopline::cloud_localisation {

/// A stretch of the log on which the place was not known.
struct LostStretch {
    std::size_t first_sweep = 0, end_sweep = 0;  ///< without the last one
    StampNs first_ns = 0, end_ns = 0;            ///< the latter of the sweep that found it, or of its last
    bool found = false;                          ///< at its end
    std::optional<PoseWithCovariance> lost_at;   ///< its first pose, as the motion went on
};

class LocalisedPath {
 public:
    void keep_in(const std::filesystem::path& folder) { sweeps_.keep_in(folder, "cloud_localisation"); }
    void add(std::uint64_t sequence, StampNs stamp_ns, const LocalisedSweep& sweep);
    std::size_t sweeps() const { return sweeps_.size(); }
    /// Sweeps whose place was never known, not even later.
    std::size_t without_place() const;
    /// The first sweep whose place was known at its time, and its stamp; none if there is none.
    std::optional<std::size_t> known_from() const { return known_from_; }
    StampNs first_ns() const { return sweeps_.empty() ? 0 : sweeps_[0].stamp_ns; }
    StampNs known_from_ns() const { return sweeps_[*known_from_].stamp_ns; }
    const std::vector<LostStretch>& lost() const { return lost_; }
    /// Those with a place.
    void lay_out(Trajectory& trajectory) const;

 private:
    template <class Archive>
    friend void fields(Archive&, LocalisedPath&);
    struct Sweep {
        std::uint64_t sequence = 0;
        StampNs stamp_ns = 0;
        Pose3Record T_map_base_online;
        Pose3Record T_map_base;  ///< while it is searched for, that in the search's own map
        std::array<double, 36> covariance{};
        std::uint64_t has_place = 0;
    };
    void lay_out_backwards(const LocalisedSweep& found);
    std::optional<PoseWithCovariance> from_where_it_was_lost(const Sweep& record) const;

    SetAside<Sweep> sweeps_;
    std::optional<std::size_t> known_from_;
    std::vector<LostStretch> lost_;  ///< the one under way included
};

}  // namespace loopline::cloud_localisation
