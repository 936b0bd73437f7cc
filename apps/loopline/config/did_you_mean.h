/// The known name nearest to a misspelt one.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace loopline {

/// Least number of insertions, deletions, substitutions and swaps of neighbours that turns one into the
/// other, no part being edited twice (optimal string alignment; Damerau 1964), upper and lower case alike.
std::size_t edit_distance(const std::string& a, const std::string& b);

/// The nearest of `known`, the first of equals; empty if none is near enough to be what was meant.
std::string nearest_name(const std::string& name, const std::vector<std::string>& known);

/// `; did you mean "name"?`, or `alternative` if nothing is near.
std::string did_you_mean(const std::string& name, const std::vector<std::string>& known,
                         const std::string& alternative = {});

/// "a, b and c"; "none" if there are none.
std::string listing(const std::vector<std::string>& names);

}  // namespace loopline
