#include "grid_slam/loop_decisions.h"

#include <algorithm>
#include <stdexcept>

#include "api/parameters.h"

namespace loopline::grid_slam {
namespace {

/// Stamps written with three decimals are meant as well as those with nine.
constexpr StampNs rounding_ns = 500'000;
constexpr StampNs outside_by_ns = 1'000'000'000;

bool is_due(StampNs wanted_ns, StampNs stamp_ns) {
    return stamp_ns >= wanted_ns - rounding_ns;
}

std::string trimmed(const std::string& text) {
    const auto words = split_words(text, " \t");
    std::string joined;
    for (const auto& word : words) joined += (joined.empty() ? "" : " ") + word;
    return joined;
}

StampNs stamp_in(const std::string& word, const std::string& item) {
    const auto stamp = stamp_from_seconds_text(trimmed(word));
    if (!stamp)
        throw std::invalid_argument("holds \"" + item + "\", where \"" + trimmed(word) +
                                    "\" is not a time in seconds");
    return *stamp;
}

/// The two sides of a separator that stands between blanks, or nothing.
std::optional<std::pair<std::string, std::string>> sides(const std::string& item,
                                                         const std::string& separator) {
    const auto at = item.find(separator);
    if (at == std::string::npos) return std::nullopt;
    return std::pair(item.substr(0, at), item.substr(at + separator.size()));
}

std::optional<LoopName> loop_in(const std::string& item) {
    const auto pair = sides(item, "-");
    if (!pair) return std::nullopt;
    const LoopName loop{stamp_in(pair->first, item), stamp_in(pair->second, item), item};
    if (loop.stamp_ns <= loop.old_stamp_ns)
        throw std::invalid_argument("holds \"" + item +
                                    "\": the later scan comes first (an interval is \"from .. to\")");
    return loop;
}

std::optional<Refusal> interval_in(const std::string& item) {
    const auto pair = sides(item, "..");
    if (!pair) return std::nullopt;
    const Refusal interval{stamp_in(pair->first, item), stamp_in(pair->second, item), std::nullopt, item};
    if (*interval.to_ns < interval.from_ns)
        throw std::invalid_argument("holds \"" + item + "\", which ends before it begins");
    return interval;
}

std::vector<std::string> items_of(const std::string& text) {
    std::vector<std::string> items;
    for (const auto& item : split_words(text, ",")) items.push_back(trimmed(item));
    return items;
}

/// The frame taken nearest to a time.
std::uint32_t frame_at(const MapFrames& map, StampNs stamp_ns) {
    const auto after = std::lower_bound(map.stamps_ns.begin(), map.stamps_ns.end(), stamp_ns - rounding_ns);
    return after == map.stamps_ns.end() ? map.last()
                                        : static_cast<std::uint32_t>(after - map.stamps_ns.begin());
}

}  // namespace

std::vector<LoopName> named_loops_from_text(const std::string& text) {
    std::vector<LoopName> loops;
    for (const auto& item : items_of(text)) {
        const auto loop = loop_in(item);
        if (!loop)
            throw std::invalid_argument("holds \"" + item + "\"; a loop is \"later - earlier\", in seconds");
        loops.push_back(*loop);
    }
    return loops;
}

std::vector<Refusal> refusals_from_text(const std::string& text) {
    std::vector<Refusal> refusals;
    for (const auto& item : items_of(text)) {
        if (auto interval = interval_in(item))
            refusals.push_back(*interval);
        else if (const auto loop = loop_in(item))
            refusals.push_back({loop->stamp_ns, std::nullopt, loop->old_stamp_ns, item});
        else
            refusals.push_back({stamp_in(item, item), std::nullopt, std::nullopt, item});
    }
    return refusals;
}

std::vector<Refusal> intervals_from_text(const std::string& text) {
    std::vector<Refusal> intervals;
    for (const auto& item : items_of(text)) {
        const auto interval = interval_in(item);
        if (!interval)
            throw std::invalid_argument("holds \"" + item + "\"; an interval is \"from .. to\", in seconds");
        intervals.push_back(*interval);
    }
    return intervals;
}

bool refuse_alike_before(const std::vector<Refusal>& a, const std::vector<Refusal>& b, StampNs loop_ns) {
    const auto covered = [loop_ns](const std::vector<Refusal>& some, const std::vector<Refusal>& by) {
        return std::all_of(some.begin(), some.end(), [&](const Refusal& r) {
            return is_due(loop_ns, r.from_ns) || std::any_of(by.begin(), by.end(), [&](const Refusal& other) {
                       return r.from_ns == other.from_ns && r.to_ns == other.to_ns &&
                              r.old_stamp_ns == other.old_stamp_ns;
                   });
        });
    };
    return covered(a, b) && covered(b, a);
}

bool LoopDecisions::is_named(StampNs stamp_ns) const {
    for (std::size_t i = 0; i < named_.size(); ++i)
        if (!named_[i].reached && is_due(settings_.named[i].stamp_ns, stamp_ns) &&
            !is_outside(settings_.named[i].stamp_ns))
            return true;
    return false;
}

void LoopDecisions::take_scan(StampNs stamp_ns, std::uint32_t frame) {
    if (!started_) first_ns_ = last_ns_ = stamp_ns;
    started_ = true;
    last_ns_ = std::max(last_ns_, stamp_ns);
    for (std::size_t i = 0; i < named_.size(); ++i) {
        if (!named_[i].old_frame && is_due(settings_.named[i].old_stamp_ns, stamp_ns))
            named_[i].old_frame = frame;
        if (is_due(settings_.named[i].stamp_ns, stamp_ns)) named_[i].reached = true;
    }
}

/// Stamps before the log are of another one: what comes then is nothing they are about.
bool LoopDecisions::is_outside(StampNs stamp_ns) const {
    return started_ && stamp_ns < first_ns_ - outside_by_ns;
}

std::optional<std::size_t> LoopDecisions::due(StampNs stamp_ns) const {
    std::optional<std::size_t> first;
    for (std::size_t i = 0; i < named_.size(); ++i) {
        const LoopName& loop = settings_.named[i];
        if (named_[i].record || !named_[i].old_frame || !is_due(loop.stamp_ns, stamp_ns) ||
            is_outside(loop.old_stamp_ns))
            continue;
        if (!first || loop.stamp_ns < settings_.named[*first].stamp_ns) first = i;
    }
    return first;
}

void LoopDecisions::tried(std::size_t named, std::size_t record) {
    named_[named].record = record;
}

bool LoopDecisions::search_is_off(StampNs stamp_ns) const {
    return std::any_of(
        settings_.without_search.begin(), settings_.without_search.end(), [&](const Refusal& interval) {
            return is_due(interval.from_ns, stamp_ns) && stamp_ns <= *interval.to_ns + rounding_ns;
        });
}

bool LoopDecisions::refuses(const MapFrames& map, std::uint32_t old_frame, std::uint32_t frame) const {
    const StampNs stamp_ns = map.stamps_ns[frame];
    for (const Refusal& r : settings_.refused) {
        if (!is_due(r.from_ns, stamp_ns)) continue;
        if (r.to_ns) {
            if (stamp_ns <= *r.to_ns + rounding_ns) return true;
            continue;
        }
        // The next match of the same place, a metre later, would be the same mistake.
        if (is_outside(r.from_ns) ||
            map.path_m[frame] - map.path_m[frame_at(map, r.from_ns)] > settings_.refuse_way_m)
            continue;
        if (!r.old_stamp_ns ||
            map.distance_m(frame_at(map, *r.old_stamp_ns), old_frame) <= settings_.refuse_way_m)
            return true;
    }
    return false;
}

std::vector<LoopDecisions::Untried> LoopDecisions::untried() const {
    std::vector<Untried> untried;
    for (std::size_t i = 0; i < named_.size(); ++i) {
        const LoopName& loop = settings_.named[i];
        if (named_[i].record) continue;
        const bool outside = is_outside(loop.old_stamp_ns) || loop.stamp_ns > last_ns_ + outside_by_ns;
        untried.push_back(
            {&loop, outside ? "no scan of the log is of that time" : "the log ends before it can be tried"});
    }
    return untried;
}

const LoopName* LoopDecisions::name_of(std::size_t record) const {
    for (std::size_t i = 0; i < named_.size(); ++i)
        if (named_[i].record == record) return &settings_.named[i];
    return nullptr;
}

std::vector<const Refusal*> LoopDecisions::outside() const {
    std::vector<const Refusal*> outside;
    for (const auto* list : {&settings_.refused, &settings_.without_search})
        for (const Refusal& r : *list) {
            const bool before_the_log =
                is_outside(r.to_ns.value_or(r.from_ns)) || (r.old_stamp_ns && is_outside(*r.old_stamp_ns));
            if (before_the_log || r.from_ns > last_ns_ + outside_by_ns) outside.push_back(&r);
        }
    return outside;
}

}  // namespace loopline::grid_slam
