/// States of a run before each of its loops was closed (states/loop_N.bin), so that one can be rejected
/// afterwards and only what comes after it done again.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/checkpoint.h"

namespace loopline {

/// Relative to the run directory: "states/loop_12.bin".
std::string kept_state_name(std::uint64_t loop);

/// Lets go of states, with their files, until the others are no more than `most_bytes`: each time of the one
/// that saves least beyond the one before it.
void thin_kept_states(const std::filesystem::path& folder, std::uint64_t most_bytes,
                      std::vector<KeptState>& states);

/// Removes all states in the run directory but these, as runs leave them that were killed.
void remove_other_states(const std::filesystem::path& folder, const std::vector<KeptState>& states);

}  // namespace loopline
