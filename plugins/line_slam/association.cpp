#include "line_slam/association.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "least_squares/chi_square.h"

namespace loopline::line_slam {
namespace {

constexpr double coarse_angle_rad = 0.5;  // nothing beyond it can be the same wall

struct Candidate {
    Pairing pairing;
    Eigen::Vector2d innovation;
    Eigen::Matrix2d S;
    double distance2 = 0;  ///< squared Mahalanobis distance by itself
    double weight_m = 0;   ///< common length: how much it says, and how hard it is to be wrong about it
};

std::vector<Candidate> compatible_pairings(const Ekf& filter, const MapLineRecords& records,
                                           const std::vector<LineObservation>& observations,
                                           const AssociationParameters& parameters) {
    std::vector<Candidate> candidates;
    for (std::size_t i = 0; i < observations.size(); ++i)
        for (const int id : filter.active_lines()) {
            const MapLineRecord& record = records[static_cast<std::size_t>(id)];
            if (!record.awake) continue;
            const LineObservation& z = observations[i];
            const Eigen::Vector2d apart =
                innovation(z.line, predicted_line(filter.T_map_base(), filter.line(id)));
            if (std::abs(apart.y()) > coarse_angle_rad) continue;
            if (!record.recent &&
                (std::abs(apart.y()) > parameters.max_surprise_rad ||
                 std::abs(apart.x() - z.line.along_m(z.middle_m()) * apart.y()) > parameters.max_surprise_m))
                continue;
            const double common_m = overlap_m(filter.T_map_base(), filter.line(id), record.extent, z);
            if (common_m < -parameters.max_gap_m) continue;
            const FeaturePrediction f = filter.prediction(id, z);
            const Eigen::Matrix2d S = filter.predicted_covariance(id, id) + f.noise;
            const Eigen::LLT<Eigen::Matrix2d> llt(S);
            if (llt.info() != Eigen::Success) continue;
            const double distance2 = llt.matrixL().solve(f.innovation).squaredNorm();
            if (!(distance2 < parameters.gate)) continue;
            candidates.push_back(
                {{id, static_cast<int>(i)}, f.innovation, S, distance2, std::max(common_m, 0.1)});
        }
    return candidates;
}

/// The pairings accepted so far, as a joint Gaussian of their innovations.
class Agreed {
 public:
    explicit Agreed(const Ekf& filter) : filter_(filter) {}

    /// Score of a candidate given what was accepted (squared distance plus log of the covariance's
    /// determinant: a vague line must not win by its vagueness); infinite if it is beyond the gate.
    double score(const Candidate& c, double gate) const {
        Eigen::Vector2d v = c.innovation;
        Eigen::Matrix2d S = c.S;
        if (!pairings_.empty()) {
            const Eigen::MatrixXd whitened_cross = llt_.matrixL().solve(cross(c));
            v -= whitened_cross.transpose() * whitened_innovation_;
            S -= whitened_cross.transpose() * whitened_cross;
        }
        const Eigen::LLT<Eigen::Matrix2d> llt(S);
        const double distance2 = llt.info() == Eigen::Success ? llt.matrixL().solve(v).squaredNorm()
                                                              : std::numeric_limits<double>::infinity();
        return distance2 < gate ? distance2 + std::log(S.determinant())
                                : std::numeric_limits<double>::infinity();
    }

    void accept(const Candidate& c) {
        const auto m = S_.rows();
        const Eigen::MatrixXd with = cross(c);
        S_.conservativeResize(m + 2, m + 2);
        S_.topRightCorner(m, 2) = with;
        S_.bottomLeftCorner(2, m) = with.transpose();
        S_.bottomRightCorner<2, 2>() = c.S;
        innovation_.conservativeResize(m + 2);
        innovation_.tail<2>() = c.innovation;
        pairings_.push_back(c.pairing);
        llt_.compute(S_);
        whitened_innovation_ = llt_.matrixL().solve(innovation_);
    }

    const std::vector<Pairing>& pairings() const { return pairings_; }
    /// Squared Mahalanobis distance of all accepted innovations together.
    double distance2() const { return whitened_innovation_.squaredNorm(); }
    void drop_last() {
        const auto m = S_.rows() - 2;
        S_.conservativeResize(m, m);
        innovation_.conservativeResize(m);
        pairings_.pop_back();
        llt_.compute(S_);
        whitened_innovation_ = llt_.matrixL().solve(innovation_);
    }

 private:
    /// Covariance of the accepted innovations with that of `c`.
    Eigen::MatrixXd cross(const Candidate& c) const {
        Eigen::MatrixXd C(S_.rows(), 2);
        for (std::size_t k = 0; k < pairings_.size(); ++k)
            C.middleRows<2>(2 * static_cast<Eigen::Index>(k)) =
                filter_.predicted_covariance(pairings_[k].line, c.pairing.line);
        return C;
    }

    const Ekf& filter_;
    std::vector<Pairing> pairings_;
    Eigen::MatrixXd S_{0, 0};
    Eigen::VectorXd innovation_{0}, whitened_innovation_{0};
    Eigen::LLT<Eigen::MatrixXd> llt_;
};

std::vector<Pairing> nearest(const std::vector<Candidate>& candidates, std::size_t observations) {
    std::vector<const Candidate*> best(observations, nullptr);
    for (const Candidate& c : candidates) {
        const Candidate*& b = best[static_cast<std::size_t>(c.pairing.observation)];
        if (!b || c.distance2 < b->distance2) b = &c;
    }
    std::vector<Pairing> pairings;
    for (const Candidate* b : best)
        if (b) pairings.push_back(b->pairing);
    return pairings;
}

std::vector<Pairing> sequential(const Ekf& filter, const std::vector<Candidate>& candidates,
                                const std::vector<int>& order, double gate) {
    Agreed agreed(filter);
    for (const int i : order) {
        const Candidate* best = nullptr;
        double least = std::numeric_limits<double>::infinity();
        for (const Candidate& c : candidates) {
            if (c.pairing.observation != i) continue;
            const double score = agreed.score(c, gate);
            if (score < least) {
                least = score;
                best = &c;
            }
        }
        if (best) agreed.accept(*best);
    }
    return agreed.pairings();
}

/// Joint compatibility branch and bound: of all sets of pairings whose joint distance is within the gate, one
/// of the largest, and of these the one with the least distance.
class BranchAndBound {
 public:
    BranchAndBound(const Ekf& filter, const std::vector<Candidate>& candidates, const std::vector<int>& order,
                   double probability)
        : candidates_(candidates), order_(order), probability_(probability), hypothesis_(filter) {
        descend(0);
    }
    const std::vector<Pairing>& best() const { return best_; }

 private:
    void descend(std::size_t depth) {
        if (depth == order_.size()) {
            const double distance2 = hypothesis_.distance2();
            const std::size_t size = hypothesis_.pairings().size();
            if (size > best_.size() || (size == best_.size() && distance2 < best_distance2_)) {
                best_ = hypothesis_.pairings();
                best_distance2_ = distance2;
            }
            return;
        }
        // Distances only grow: what can't get larger than the best must at least stay nearer.
        const auto can_win = [&](std::size_t more) {
            const std::size_t reach = hypothesis_.pairings().size() + more;
            return reach > best_.size() ||
                   (reach == best_.size() && hypothesis_.distance2() < best_distance2_);
        };
        for (const Candidate& c : candidates_) {
            if (c.pairing.observation != order_[depth] || ++nodes_ > max_nodes) continue;
            if (!can_win(order_.size() - depth)) return;
            const double degrees = 2 * static_cast<double>(hypothesis_.pairings().size() + 1);
            hypothesis_.accept(c);
            if (hypothesis_.distance2() < least_squares::chi_square_quantile(degrees, probability_)) descend(depth + 1);
            hypothesis_.drop_last();
        }
        if (can_win(order_.size() - depth - 1)) descend(depth + 1);
    }

    static constexpr int max_nodes = 20'000;  // a crowd of alike walls must not stop the run
    const std::vector<Candidate>& candidates_;
    const std::vector<int>& order_;
    double probability_;
    Agreed hypothesis_;
    std::vector<Pairing> best_;
    double best_distance2_ = std::numeric_limits<double>::infinity();
    int nodes_ = 0;
};

}  // namespace

double overlap_m(const Pose2& T_map_base, const PlanarLine& line_map, const Extent& seen,
                 const LineObservation& observation) {
    const PlanarLine predicted = predicted_line(T_map_base, line_map);
    const double shift_m = line_map.along_m(T_map_base.translation());
    return Extent{seen.from_m - shift_m, seen.to_m - shift_m}.overlap_m(
        Extent::of(predicted, observation.start_m, observation.end_m));
}

Association associate(const Ekf& filter, const MapLineRecords& records,
                      const std::vector<LineObservation>& observations,
                      const AssociationParameters& parameters) {
    const std::vector<Candidate> candidates = compatible_pairings(filter, records, observations, parameters);
    Association result;
    result.is_compatible.assign(observations.size(), false);
    std::vector<double> weight_m(observations.size(), 0.0);
    for (const Candidate& c : candidates) {
        const auto i = static_cast<std::size_t>(c.pairing.observation);
        result.is_compatible[i] = true;
        weight_m[i] = std::max(weight_m[i], c.weight_m);
    }
    // The longest first: they are the hardest to be wrong about.
    std::vector<int> order;
    for (std::size_t i = 0; i < observations.size(); ++i)
        if (result.is_compatible[i]) order.push_back(static_cast<int>(i));
    std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
        return weight_m[static_cast<std::size_t>(a)] > weight_m[static_cast<std::size_t>(b)];
    });
    switch (parameters.method) {
        case AssociationMethod::nearest:
            result.pairings = nearest(candidates, observations.size());
            break;
        case AssociationMethod::sequential:
            result.pairings = sequential(filter, candidates, order, parameters.gate);
            break;
        case AssociationMethod::jcbb:
            result.pairings = BranchAndBound(filter, candidates, order, parameters.probability).best();
            break;
    }
    result.refused = static_cast<int>(order.size() - result.pairings.size());
    std::sort(result.pairings.begin(), result.pairings.end(),
              [](const Pairing& a, const Pairing& b) { return a.observation < b.observation; });
    return result;
}

}  // namespace loopline::line_slam
