#include "line_slam/place_recognition.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace loopline::line_slam {
namespace {

constexpr std::size_t max_seeds = 40;
constexpr double max_credit_m = 5;  // one long wall must not outvote the rest

struct Pair {
    std::size_t recent, old;
};

/// Common length of two lines if they are the same one within the tolerance, else 0.
double agreement_m(const PlanarLine& moved, const Extent& extent, const PlaceLine& old,
                   const RecognitionParameters& parameters) {
    if (std::abs(wrap_to_pi(moved.alpha_rad - old.line.alpha_rad)) > parameters.tolerance_rad) return 0;
    const Eigen::Vector2d a = moved.point_m(extent.from_m), b = moved.point_m(extent.to_m);
    const Extent on_old = Extent::of(old.line, a, b);
    const double common_m = old.extent.overlap_m(on_old);
    if (common_m <= 0) return 0;
    // Distance at the ends of the common stretch.
    const double da = old.line.signed_distance_m(a), db = old.line.signed_distance_m(b);
    const double sa = old.line.along_m(a), sb = old.line.along_m(b);
    for (const double s :
         {std::max(on_old.from_m, old.extent.from_m), std::min(on_old.to_m, old.extent.to_m)}) {
        const double u = std::abs(sb - sa) > 1e-9 ? (s - sa) / (sb - sa) : 0.0;
        if (std::abs(da + u * (db - da)) > parameters.tolerance_m) return 0;
    }
    return common_m;
}

/// Extent of a displaced line, along its own new tangent.
Extent displaced(const Pose2& T, const PlanarLine& moved, const PlaceLine& l) {
    return Extent::of(moved, T * l.line.point_m(l.extent.from_m), T * l.line.point_m(l.extent.to_m));
}

/// All pairings that agree with T, the longest for each recent line; `pairs` are ordered by recent line.
Recognition agreement(const std::vector<PlaceLine>& recent, const std::vector<PlaceLine>& old,
                      const std::vector<Pair>& pairs, const Pose2& T,
                      const RecognitionParameters& parameters) {
    Recognition r;
    r.T_old_recent = T;
    for (std::size_t p = 0; p < pairs.size();) {
        const std::size_t i = pairs[p].recent;
        const PlanarLine moved = transformed(T, recent[i].line);
        const Extent extent = displaced(T, moved, recent[i]);
        double best_m = 0;
        int best = -1;
        for (; p < pairs.size() && pairs[p].recent == i; ++p) {
            const double common_m = agreement_m(moved, extent, old[pairs[p].old], parameters);
            if (common_m <= best_m) continue;
            best_m = common_m;
            best = old[pairs[p].old].id;
        }
        if (best < 0) continue;
        r.matches.emplace_back(recent[i].id, best);
        r.score_m += std::min(best_m, max_credit_m);
    }
    return r;
}

/// The longest pairs, as seeds of a displacement: quadratic work must not grow with the place.
std::vector<Pair> longest(std::vector<Pair> pairs, const std::vector<PlaceLine>& recent,
                          const std::vector<PlaceLine>& old) {
    const auto length_m = [&](const Pair& p) {
        return std::min(recent[p.recent].extent.length_m(), old[p.old].extent.length_m());
    };
    std::stable_sort(pairs.begin(), pairs.end(),
                     [&](const Pair& a, const Pair& b) { return length_m(a) > length_m(b); });
    if (pairs.size() > max_seeds) pairs.resize(max_seeds);
    return pairs;
}

/// The rotation about the origin and shift that put lines a, b onto A, B: heading by their mean, shift by
/// both distances.
std::optional<Pose2> displacement(const PlaceLine& a, const PlaceLine& A, const PlaceLine& b,
                                  const PlaceLine& B) {
    const double turn_a = wrap_to_pi(A.line.alpha_rad - a.line.alpha_rad);
    const double turn_b = wrap_to_pi(B.line.alpha_rad - b.line.alpha_rad);
    const double weight_a = std::pow(std::min(a.extent.length_m(), A.extent.length_m()), 2);
    const double weight_b = std::pow(std::min(b.extent.length_m(), B.extent.length_m()), 2);
    const double turn = turn_a + wrap_to_pi(turn_b - turn_a) * weight_b / (weight_a + weight_b);
    Eigen::Matrix2d normals;
    normals << A.line.normal().transpose(), B.line.normal().transpose();
    if (std::abs(normals.determinant()) < 0.5) return std::nullopt;
    const Eigen::Vector2d shift =
        normals.inverse() * Eigen::Vector2d(A.line.rho_m - a.line.rho_m, B.line.rho_m - b.line.rho_m);
    return Pose2{shift.x(), shift.y(), turn};
}

double shift_at(const Pose2& T, const Eigen::Vector2d& centre_m) {
    return (T * centre_m - centre_m).norm();
}

}  // namespace

std::optional<Recognition> recognise_place(const std::vector<PlaceLine>& recent,
                                           const std::vector<PlaceLine>& old, const Eigen::Vector2d& centre_m,
                                           const RecognitionParameters& parameters) {
    // About the vehicle, where rotation and shift are independent and the numbers small.
    const Pose2 T_centre_map{-centre_m.x(), -centre_m.y(), 0};
    const auto about_centre = [&](std::vector<PlaceLine> lines) {
        for (PlaceLine& l : lines) {
            const double along_centre_m = l.line.along_m(centre_m);
            l.line = transformed(T_centre_map, l.line);
            l.extent = {l.extent.from_m - along_centre_m, l.extent.to_m - along_centre_m};
        }
        return lines;
    };
    const std::vector<PlaceLine> r = about_centre(recent), o = about_centre(old);
    const Eigen::Vector2d zero = Eigen::Vector2d::Zero();

    std::vector<Pair> pairs;
    for (std::size_t i = 0; i < r.size(); ++i)
        for (std::size_t j = 0; j < o.size(); ++j) {
            if (std::abs(wrap_to_pi(r[i].line.alpha_rad - o[j].line.alpha_rad)) > parameters.max_turn_rad)
                continue;
            const Eigen::Vector2d middle = r[i].line.point_m(0.5 * (r[i].extent.from_m + r[i].extent.to_m));
            const double reach_m = parameters.max_shift_m + parameters.max_turn_rad * middle.norm();
            if (std::abs(o[j].line.signed_distance_m(middle)) > reach_m) continue;
            const Eigen::Vector2d a = r[i].line.point_m(r[i].extent.from_m),
                                  b = r[i].line.point_m(r[i].extent.to_m);
            if (o[j].extent.overlap_m(Extent::of(o[j].line, a, b)) < -parameters.max_shift_m) continue;
            pairs.push_back({i, j});
        }

    std::vector<Recognition> found;
    const std::vector<Pair> seeds = longest(pairs, r, o);
    for (std::size_t p = 0; p < seeds.size(); ++p)
        for (std::size_t q = p + 1; q < seeds.size(); ++q) {
            if (seeds[p].recent == seeds[q].recent) continue;
            const auto T =
                displacement(r[seeds[p].recent], o[seeds[p].old], r[seeds[q].recent], o[seeds[q].old]);
            if (!T || shift_at(*T, zero) > parameters.max_shift_m ||
                std::abs(T->phi_rad) > parameters.max_turn_rad)
                continue;
            Recognition candidate = agreement(r, o, pairs, *T, parameters);
            if (static_cast<int>(candidate.matches.size()) >= parameters.min_lines)
                found.push_back(std::move(candidate));
        }
    if (found.empty()) return std::nullopt;
    const auto best = std::max_element(found.begin(), found.end(),
                                       [](const auto& a, const auto& b) { return a.score_m < b.score_m; });
    double recent_length_m = 0, rival_m = 0;
    for (const PlaceLine& l : r) recent_length_m += std::min(l.extent.length_m(), max_credit_m);
    for (const Recognition& f : found) {
        const Pose2 apart = best->T_old_recent.inverse() * f.T_old_recent;
        if (apart.translation().norm() > 3 * parameters.tolerance_m ||
            std::abs(apart.phi_rad) > 2 * parameters.tolerance_rad)
            rival_m = std::max(rival_m, f.score_m);
    }
    if (best->score_m < parameters.min_length_m || best->score_m < parameters.min_share * recent_length_m ||
        rival_m > parameters.max_rival * best->score_m)
        return std::nullopt;
    Recognition result = *best;
    result.rival_m = rival_m;
    // Back about the map's origin.
    result.T_old_recent = T_centre_map.inverse() * best->T_old_recent * T_centre_map;
    return result;
}

}  // namespace loopline::line_slam
