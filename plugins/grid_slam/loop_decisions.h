/// What people decide about loops (row B5 of the method, by hand): loops that are named, to be tried whatever
/// the uncertainty says; loops that are refused; parts of the log in which none is looked for.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "api/stamp.h"
#include "grid_slam/map_frames.h"

namespace loopline::grid_slam {

/// "1118420800.12 - 1118420100.5": the scan at the later time is where the one at the earlier time was.
struct LoopName {
    StampNs stamp_ns = 0, old_stamp_ns = 0;
    std::string text;  ///< as it was written
};

/// What is refused from one time on: to another one, or for some way, perhaps of one place only.
struct Refusal {
    StampNs from_ns = 0;
    std::optional<StampNs> to_ns;         ///< "from .. to"
    std::optional<StampNs> old_stamp_ns;  ///< "later - earlier"
    std::string text;
};

struct DecisionSettings {
    std::vector<LoopName> named;
    std::vector<Refusal> refused;
    std::vector<Refusal> without_search;  ///< intervals
    double refuse_way_m = 10;  ///< of the vehicle from the later scan on, and about the earlier one
};

/// Of the .ini's text; throws std::invalid_argument with a clause that fits after the key.
std::vector<LoopName> named_loops_from_text(const std::string& text);
std::vector<Refusal> refusals_from_text(const std::string& text);
std::vector<Refusal> intervals_from_text(const std::string& text);

/// Whether both refuse the same in what comes before the loop whose later scan is at a stamp.
bool refuse_alike_before(const std::vector<Refusal>& a, const std::vector<Refusal>& b, StampNs loop_ns);

class LoopDecisions {
 public:
    explicit LoopDecisions(DecisionSettings settings)
        : settings_(std::move(settings)), named_(settings_.named.size()) {}

    /// Whether a named loop has its later scan here: it must be a frame of the map.
    bool is_named(StampNs stamp_ns) const;
    /// Each scan, and the frame that it rides on.
    void take_scan(StampNs stamp_ns, std::uint32_t frame);

    /// The next named loop whose later scan has come; its place in the list.
    std::optional<std::size_t> due(StampNs stamp_ns) const;
    std::uint32_t old_frame(std::size_t named) const { return named_[named].old_frame.value_or(0); }
    /// It made the record of this index.
    void tried(std::size_t named, std::size_t record);

    bool search_is_off(StampNs stamp_ns) const;
    /// Whether a loop between two frames of the map is refused.
    bool refuses(const MapFrames& map, std::uint32_t old_frame, std::uint32_t frame) const;

    /// Named loops that were never tried, each with the reason.
    struct Untried {
        const LoopName* loop;
        std::string reason;
    };
    std::vector<Untried> untried() const;
    /// The .ini's name of the loop that made a record; null if it names none.
    const LoopName* name_of(std::size_t record) const;
    /// Refusals of times that the log does not have.
    std::vector<const Refusal*> outside() const;
    StampNs first_ns() const { return first_ns_; }
    StampNs last_ns() const { return last_ns_; }

 private:
    template <class Archive>
    friend void fields(Archive&, LoopDecisions&);
    struct Named {
        std::optional<std::uint32_t> old_frame;  ///< that the earlier scan rode on
        bool reached = false;                    ///< by a scan at the later time
        std::optional<std::uint64_t> record;     ///< what came of it
    };

    bool is_outside(StampNs stamp_ns) const;

    DecisionSettings settings_;
    std::vector<Named> named_;
    bool started_ = false;
    StampNs first_ns_ = 0, last_ns_ = 0;  ///< of the scans so far
};

}  // namespace loopline::grid_slam
