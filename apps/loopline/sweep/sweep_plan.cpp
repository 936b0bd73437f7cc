#include "sweep/sweep_plan.h"

#include <charconv>

#include "api/parameters.h"
#include "commands/command.h"

namespace loopline {

Variation variation_from_text(const std::string& text) {
    const auto equals = text.find('=');
    const auto dot = text.find('.');
    Variation variation;
    if (equals != std::string::npos && dot != std::string::npos && dot > 0 && dot + 1 < equals) {
        variation.key = text.substr(0, equals);
        variation.values = split_words(text.substr(equals + 1), ",");
    }
    if (variation.values.empty())
        throw CommandError(exit_configuration,
                           "--vary " + text +
                               " is not a key with its values; write SECTION.KEY=VALUE,VALUE,..."
                               " such as line_slam.interval_scans=1,5,20");
    return variation;
}

std::vector<std::uint64_t> seeds_from_text(const std::string& text) {
    constexpr std::uint64_t most_seeds = 100'000;
    const auto number = [](const std::string& word, std::uint64_t& value) {
        const auto result = std::from_chars(word.data(), word.data() + word.size(), value);
        return result.ec == std::errc() && result.ptr == word.data() + word.size();
    };
    std::vector<std::uint64_t> seeds;
    bool good = true;
    for (const std::string& word : split_words(text, ",")) {
        const auto dash = word.find('-');
        std::uint64_t first = 0, last = 0;
        good = good && number(word.substr(0, dash), first);
        last = first;
        if (dash != std::string::npos) good = good && number(word.substr(dash + 1), last);
        good = good && last >= first && last - first < most_seeds;
        for (std::uint64_t seed = first; good && seed <= last; ++seed) seeds.push_back(seed);
    }
    if (!good || seeds.empty())
        throw CommandError(exit_configuration,
                           "--seeds " + text + " is no list of seeds; write 1-20 or 1,4,7-9");
    return seeds;
}

std::vector<std::vector<std::string>> combinations_of(const std::vector<Variation>& variations) {
    std::vector<std::vector<std::string>> combinations{{}};
    for (const Variation& variation : variations) {
        std::vector<std::vector<std::string>> longer;
        for (const auto& combination : combinations)
            for (const std::string& value : variation.values) {
                longer.push_back(combination);
                longer.back().push_back(value);
            }
        combinations = std::move(longer);
    }
    return combinations;
}

}  // namespace loopline
