#include "pipeline/kept_states.h"

#include <algorithm>
#include <cctype>
#include <numeric>

namespace loopline {
namespace {

/// Ours are named "loop_NUMBER.bin", perhaps with ".part" behind.
bool is_kept_state(const std::filesystem::path& file) {
    const std::string name = file.filename().string(), front = "loop_";
    if (name.rfind(front, 0) != 0) return false;
    auto at = name.begin() + static_cast<std::ptrdiff_t>(front.size());
    while (at != name.end() && std::isdigit(static_cast<unsigned char>(*at))) ++at;
    const std::string end(at, name.end());
    return end == ".bin" || end == ".bin.part";
}

}  // namespace

std::string kept_state_name(std::uint64_t loop) {
    return "states/loop_" + std::to_string(loop) + ".bin";
}

void thin_kept_states(const std::filesystem::path& folder, std::uint64_t most_bytes,
                      std::vector<KeptState>& states) {
    const auto bytes = [&states] {
        return std::accumulate(states.begin(), states.end(), std::uint64_t{0},
                               [](std::uint64_t sum, const KeptState& s) { return sum + s.bytes; });
    };
    while (!states.empty() && bytes() > most_bytes) {
        std::size_t least = 0;
        const auto saved_items = [&states](std::size_t i) {
            return states[i].items - (i == 0 ? 0 : states[i - 1].items);
        };
        for (std::size_t i = 1; i < states.size(); ++i)
            if (saved_items(i) < saved_items(least)) least = i;
        std::error_code ignored;
        std::filesystem::remove(folder / kept_state_name(states[least].loop), ignored);
        states.erase(states.begin() + static_cast<std::ptrdiff_t>(least));
    }
}

void remove_other_states(const std::filesystem::path& folder, const std::vector<KeptState>& states) {
    std::error_code none;
    std::vector<std::filesystem::path> others;
    for (const auto& entry : std::filesystem::directory_iterator(folder / "states", none)) {
        const bool known = std::any_of(states.begin(), states.end(), [&](const KeptState& state) {
            return entry.path() == folder / kept_state_name(state.loop);
        });
        if (!known && is_kept_state(entry.path())) others.push_back(entry.path());
    }
    for (const auto& file : others) std::filesystem::remove(file, none);
    std::filesystem::remove(folder / "states", none);  // if it is empty
}

}  // namespace loopline
