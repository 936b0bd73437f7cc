/// What a sweep runs: every combination of the values of some keys, each on every log.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace loopline {

/// One key and the values that it takes.
struct Variation {
    std::string key;  ///< "line_slam.interval_scans"
    std::vector<std::string> values;
};

/// "section.key=value,value,...". Throws CommandError(exit_configuration) with a sentence for anything else.
Variation variation_from_text(const std::string& text);

/// "1-20", "3", "1,4,7-9". Throws CommandError(exit_configuration).
std::vector<std::uint64_t> seeds_from_text(const std::string& text);

/// All combinations of one value of each variation, in their order, the last one varying fastest; one empty
/// combination if there is no variation.
std::vector<std::vector<std::string>> combinations_of(const std::vector<Variation>& variations);

/// A log that every combination is run on.
struct SweepLog {
    std::string name;                    ///< "seed 3", or the log's file name; empty: that of the .ini
    std::vector<std::string> arguments;  ///< of `loopline run`
};

}  // namespace loopline
