#include "lidar_mapping/standstill.h"

#include <algorithm>
#include <cmath>

namespace loopline::lidar_mapping {
namespace {

constexpr int pieces = 180;  ///< of a turn
constexpr int learnt_sweeps = 5;
constexpr double fewest = 4;  ///< returns in a piece
constexpr float smooth_m =
    0.3F;                   ///< a piece across an edge has a larger standard deviation, and says nothing
constexpr double most = 9;  ///< that one piece may count: somebody may pass by

}  // namespace

void Standstill::measure(const lidar::SpinningScan& scan) {
    now_.assign(scan.rings() * pieces, {});
    for (std::size_t ring = 0; ring < scan.rings(); ++ring) {
        Piece* const of_ring = now_.data() + ring * pieces;
        for (std::size_t k = scan.ring_begin[ring]; k < scan.ring_begin[ring + 1]; ++k) {
            const lidar::SpinningPoint& p = scan.points[k];
            const double turn =
                std::atan2(static_cast<double>(p.y_m), static_cast<double>(p.x_m)) / (2 * M_PI) + 0.5;
            Piece& piece = of_ring[std::min(static_cast<int>(turn * pieces), pieces - 1)];
            const float range_m = std::sqrt(p.x_m * p.x_m + p.y_m * p.y_m + p.z_m * p.z_m);
            ++piece.n;
            piece.sum_m += range_m;
            piece.squares_m2 += range_m * range_m;
        }
    }
}

Standstill::BySector Standstill::changes() const {
    BySector changes;
    if (now_.size() != learnt_.size()) return changes;
    for (std::size_t k = 0; k < now_.size(); ++k) {
        const Piece &a = now_[k], &b = learnt_[k];
        if (a.n < fewest || b.n < fewest) continue;
        const double mean_a = a.sum_m / a.n, mean_b = b.sum_m / b.n, freedom = a.n + b.n - 2;
        const double scatter_m2 =
            std::max(0.0, a.squares_m2 - a.sum_m * mean_a + b.squares_m2 - b.sum_m * mean_b) / freedom + 1e-6;
        if (scatter_m2 > smooth_m * smooth_m) continue;
        // Student's t, whose square has the mean freedom / (freedom - 2).
        const double d2 = std::min(most, (mean_a - mean_b) * (mean_a - mean_b) /
                                             (scatter_m2 * (1 / a.n + 1 / b.n)) * (freedom - 2) / freedom);
        Changes& sector = changes[k % pieces * sectors / pieces];
        ++sector.n;
        sector.sum += d2;
        sector.squares += d2 * d2;
    }
    return changes;
}

/// Before it is known what is usual: more than the scatter within the pieces explains, all of them together.
bool Standstill::drives_from_the_first(const BySector& changes) {
    double n = 0, sum = 0;
    for (const Changes& sector : changes) {
        n += sector.n;
        sum += sector.sum;
    }
    constexpr double fewest_pieces = 100, contradiction = 6;
    return n < fewest_pieces || (sum / n - 1) / std::sqrt(2 / n) > contradiction;
}

/// Others who pass by change what is seen in a few sectors, one's own way in more.
bool Standstill::has_left(const BySector& changes) const {
    constexpr double contradiction = 3, few_pieces = 20;
    constexpr int others = 6;  // somebody may reach over three, and have left three
    int changed = 0, known = 0;
    for (std::size_t k = 0; k < sectors; ++k) {
        const Changes &now = changes[k], &usual = usual_[k];
        if (now.n < few_pieces || usual.n < few_pieces) continue;
        ++known;
        const double sigma = std::sqrt(now.variance_of_mean() + usual.variance_of_mean());
        changed += now.mean() - usual.mean() > contradiction * sigma ? 1 : 0;
    }
    return known <= others || changed > others;
}

void Standstill::learn(const BySector& changes) {
    if (learnt_.empty()) learnt_.resize(now_.size());
    for (std::size_t k = 0; k < now_.size(); ++k) {
        learnt_[k].n += now_[k].n;
        learnt_[k].sum_m += now_[k].sum_m;
        learnt_[k].squares_m2 += now_[k].squares_m2;
    }
    for (std::size_t k = 0; k < sectors; ++k) {
        usual_[k].n += changes[k].n;
        usual_[k].sum += changes[k].sum;
        usual_[k].squares += changes[k].squares;
    }
}

bool Standstill::lasts(const lidar::SpinningScan& scan) {
    measure(scan);
    const BySector by_sector = changes();
    if (sweeps_ >= learnt_sweeps ? has_left(by_sector) : sweeps_ > 0 && drives_from_the_first(by_sector))
        return false;
    if (sweeps_++ < learnt_sweeps) learn(by_sector);
    return true;
}

}  // namespace loopline::lidar_mapping
