#include "config/did_you_mean.h"

#include <algorithm>
#include <cctype>

namespace loopline {
namespace {

std::string lower(std::string text) {
    for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return text;
}

}  // namespace

std::size_t edit_distance(const std::string& first, const std::string& second) {
    const std::string a = lower(first), b = lower(second);
    std::vector<std::size_t> before_last, last(b.size() + 1), row(b.size() + 1);
    for (std::size_t j = 0; j <= b.size(); ++j) last[j] = j;
    for (std::size_t i = 1; i <= a.size(); ++i) {
        row[0] = i;
        for (std::size_t j = 1; j <= b.size(); ++j) {
            row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + (a[i - 1] != b[j - 1])});
            const bool swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
            if (swapped) row[j] = std::min(row[j], before_last[j - 2] + 1);
        }
        before_last = last;
        last = row;
    }
    return last[b.size()];
}

std::string nearest_name(const std::string& name, const std::vector<std::string>& known) {
    std::string nearest;
    std::size_t least = 0;
    for (const auto& candidate : known) {
        const std::size_t distance = edit_distance(name, candidate);
        if (nearest.empty() || distance < least) {
            nearest = candidate;
            least = distance;
        }
    }
    if (nearest.empty()) return {};
    // A third of the letters may be wrong; or a word was left out at either end ("sigma_range" for
    // "sigma_range_m").
    const bool near = 3 * least <= std::max(name.size(), nearest.size());
    if (near) return nearest;
    const std::string wanted = lower(name);
    for (const auto& candidate : known) {
        const std::string text = lower(candidate);
        if (wanted.size() >= 3 && text.find(wanted) != std::string::npos) return candidate;
        if (text.size() >= 3 && wanted.find(text) != std::string::npos) return candidate;
    }
    return {};
}

std::string did_you_mean(const std::string& name, const std::vector<std::string>& known,
                         const std::string& alternative) {
    const std::string nearest = nearest_name(name, known);
    return nearest.empty() ? alternative : "; did you mean \"" + nearest + "\"?";
}

std::string listing(const std::vector<std::string>& names) {
    if (names.empty()) return "none";
    std::string text = names.front();
    for (std::size_t i = 1; i < names.size(); ++i)
        text += (i + 1 == names.size() ? " and " : ", ") + names[i];
    return text;
}

}  // namespace loopline
