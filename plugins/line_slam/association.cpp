#include "line_slam/association.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numeric>

namespace loopline::line_slam {
namespace {

constexpr double coarse_angle_rad = 0.5;  // nothing beyond it can be the same wall

struct Candidate {
    Pairing pairing;
    Eigen::Vector2d innovation;
    Eigen::Matrix2d S;
    double weight_m = 0;  ///< common length: how much it says, and how hard it is to be wrong about it
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
            const Eigen::Vector2d v =
                innovation(z.line, predicted_line(filter.T_map_base(), filter.line(id)));
            if (std::abs(v.y()) > coarse_angle_rad) continue;
            if (!record.recent &&
                (std::abs(v.y()) > parameters.max_surprise_rad ||
                 std::abs(v.x() - z.line.along_m(z.middle_m()) * v.y()) > parameters.max_surprise_m))
                continue;
            const double common_m = overlap_m(filter.T_map_base(), filter.line(id), record.extent, z);
            if (common_m < -parameters.max_gap_m) continue;
            const Eigen::Matrix2d S = filter.predicted_covariance(id, id) + z.covariance;
            const Eigen::LLT<Eigen::Matrix2d> llt(S);
            if (llt.info() != Eigen::Success || !(llt.matrixL().solve(v).squaredNorm() < parameters.gate))
                continue;
            candidates.push_back({{id, static_cast<int>(i)}, v, S, std::max(common_m, 0.1)});
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
    std::vector<std::size_t> order(observations.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return weight_m[a] > weight_m[b]; });

    Agreed agreed(filter);
    for (const std::size_t i : order) {
        if (!result.is_compatible[i]) continue;
        const Candidate* best = nullptr;
        double least = std::numeric_limits<double>::infinity();
        for (const Candidate& c : candidates) {
            if (c.pairing.observation != static_cast<int>(i)) continue;
            const double score = agreed.score(c, parameters.gate);
            if (score < least) {
                least = score;
                best = &c;
            }
        }
        if (!best) {
            ++result.refused;
            continue;
        }
        agreed.accept(*best);
    }
    result.pairings = agreed.pairings();
    std::sort(result.pairings.begin(), result.pairings.end(),
              [](const Pairing& a, const Pairing& b) { return a.observation < b.observation; });
    return result;
}

}  // namespace loopline::line_slam
