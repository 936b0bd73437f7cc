#include "fusion/heading_start.h"

#include <cmath>

namespace loopline::fusion {
namespace {

constexpr double path_sigma_m = 0.02;  // of a place by the odometry against its neighbours
constexpr double seen_every_m = 0.3;   // way between fixes that the heading is sought by
constexpr std::size_t most_seen = 80;
constexpr double largest_misfit = 4;
constexpr std::size_t enough_to_judge = 12;
constexpr double better_among_others = 3;  // else the next reflected one could pass for a wrong heading
constexpr double most_part = 0.6;          // of the fixes, that must agree

}  // namespace

std::optional<FoundHeading> HeadingStart::see(double time_s, const Eigen::Vector3d& p_local_m,
                                              const Eigen::Vector3d& p_enu_m, gnss::SigmaOfFix sigma,
                                              const Settings& settings) {
    if (!seen_.empty() && (p_local_m - seen_.back().p_local_m).norm() < seen_every_m) return std::nullopt;
    if (seen_.size() >= most_seen) {  // every second one
        std::size_t kept = 0;
        for (std::size_t i = 0; i < seen_.size(); i += 2) seen_[kept++] = seen_[i];
        seen_.resize(kept);
    }
    // Wheels' scale, and a bend that they do not tell: a chord's error and an arc's height.
    const double way_m = seen_.empty() ? 0 : (p_local_m - seen_.front().p_local_m).norm();
    const double path_m =
        path_sigma_m + way_m * (settings.wheels[way_scale] / 2 + settings.wheels[bend] * way_m / 8);
    for (double& white_m : sigma.white_m) white_m = std::hypot(white_m, path_m);
    seen_.push_back({time_s, p_local_m, p_enu_m, sigma});

    const auto found = find_heading(seen_);
    if (!found) return std::nullopt;
    if (found->misfit <= largest_misfit) return found->sigma_rad <= settings.sigma_rad ? found : std::nullopt;
    if (seen_.size() < enough_to_judge) return std::nullopt;
    // Some of them were reflected.
    const std::vector<SeenFix> most = agreeing(seen_);
    if (static_cast<double>(most.size()) >= most_part * static_cast<double>(seen_.size())) {
        const auto without_others = find_heading(most);
        if (without_others && without_others->misfit <= largest_misfit &&
            without_others->sigma_rad <= settings.sigma_rad / better_among_others)
            return without_others;
    }
    // Or the path has bent since by what its odometry does not know: look at its last part only.
    seen_.erase(seen_.begin(), seen_.begin() + static_cast<std::ptrdiff_t>(seen_.size() / 2));
    return std::nullopt;
}

}  // namespace loopline::fusion
