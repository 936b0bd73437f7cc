#include "simulation/town/spline_ground.h"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <array>
#include <cmath>

namespace loopline::simulation {
namespace {

constexpr double knot_m = 10;       ///< from knot to knot
constexpr double stiffness = 0.02;  ///< weight of a second difference against that of a point

std::array<double, 4> spline_weights(double u) {
    const double w = 1 - u;
    return {w * w * w / 6, (3 * u * u * u - 6 * u * u + 4) / 6, (3 * w * w * w - 6 * w * w + 4) / 6,
            u * u * u / 6};
}
std::array<double, 4> slope_weights(double u) {
    const double w = 1 - u;
    return {-w * w / 2, (3 * u * u - 4 * u) / 2, (-3 * w * w + 4 * w) / 2, u * u / 2};
}

/// Sums of squares, term by term.
class Normal {
 public:
    explicit Normal(Eigen::Index size) : right_(Eigen::VectorXd::Zero(size)) {}

    /// weight (sum of factors times unknowns - value)^2.
    void add(const std::vector<std::pair<int, double>>& factors, double value, double weight) {
        for (const auto& [i, a] : factors) {
            right_[i] += weight * a * value;
            for (const auto& [j, b] : factors)
                if (j <= i) terms_.emplace_back(i, j, weight * a * b);
        }
    }
    Eigen::VectorXd solve() const {
        Eigen::SparseMatrix<double> lower(right_.size(), right_.size());
        lower.setFromTriplets(terms_.begin(), terms_.end());
        return Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>(lower).solve(right_);
    }

 private:
    Eigen::VectorXd right_;
    std::vector<Eigen::Triplet<double>> terms_;
};

}  // namespace

SplineGround::SplineGround(const std::vector<Eigen::Vector3d>& points_m, double reach_m) {
    Eigen::Vector2d least_m(1e300, 1e300), most_m(-1e300, -1e300);
    for (const Eigen::Vector3d& p : points_m) {
        least_m = least_m.cwiseMin(p.head<2>());
        most_m = most_m.cwiseMax(p.head<2>());
    }
    origin_m_ = least_m - Eigen::Vector2d::Constant(reach_m);
    columns_ = static_cast<int>(std::ceil((most_m.x() - least_m.x() + 2 * reach_m) / knot_m)) + 3;
    rows_ = static_cast<int>(std::ceil((most_m.y() - least_m.y() + 2 * reach_m) / knot_m)) + 3;

    Normal normal(columns_ * rows_);
    for (const Eigen::Vector3d& p : points_m) {
        const Spot s = spot(p.head<2>());
        const auto along = spline_weights(s.u), across = spline_weights(s.v);
        std::vector<std::pair<int, double>> factors;
        for (int j = 0; j < 4; ++j)
            for (int i = 0; i < 4; ++i)
                factors.emplace_back(index(s.column + i, s.row + j), along[static_cast<std::size_t>(i)] *
                                                                         across[static_cast<std::size_t>(j)]);
        normal.add(factors, p.z(), 1);
    }
    for (int row = 0; row < rows_; ++row)
        for (int column = 0; column < columns_; ++column) {
            if (column > 0 && column + 1 < columns_)
                normal.add(
                    {{index(column - 1, row), 1}, {index(column, row), -2}, {index(column + 1, row), 1}}, 0,
                    stiffness);
            if (row > 0 && row + 1 < rows_)
                normal.add(
                    {{index(column, row - 1), 1}, {index(column, row), -2}, {index(column, row + 1), 1}}, 0,
                    stiffness);
            if (column + 1 < columns_ && row + 1 < rows_)
                normal.add({{index(column, row), 1},
                            {index(column + 1, row), -1},
                            {index(column, row + 1), -1},
                            {index(column + 1, row + 1), 1}},
                           0, stiffness);
        }
    const Eigen::VectorXd solution = normal.solve();
    control_m_.assign(solution.data(), solution.data() + solution.size());
}

SplineGround::Spot SplineGround::spot(const Eigen::Vector2d& place_m) const {
    const Eigen::Vector2d at = (place_m - origin_m_) / knot_m;
    const double x = std::clamp(at.x(), 0.0, columns_ - 3 - 1e-9),
                 y = std::clamp(at.y(), 0.0, rows_ - 3 - 1e-9);
    const int column = static_cast<int>(x), row = static_cast<int>(y);
    return {column, row, x - column, y - row, x != at.x(), y != at.y()};
}

double SplineGround::height_m(const Eigen::Vector2d& place_m) const {
    const Spot s = spot(place_m);
    const auto along = spline_weights(s.u), across = spline_weights(s.v);
    double sum_m = 0;
    for (std::size_t j = 0; j < 4; ++j)
        for (std::size_t i = 0; i < 4; ++i)
            sum_m += along[i] * across[j] *
                     control_m_[static_cast<std::size_t>(
                         index(s.column + static_cast<int>(i), s.row + static_cast<int>(j)))];
    return sum_m;
}

Eigen::Vector2d SplineGround::slope(const Eigen::Vector2d& place_m) const {
    const Spot s = spot(place_m);
    const auto along = spline_weights(s.u), across = spline_weights(s.v), along_slope = slope_weights(s.u),
               across_slope = slope_weights(s.v);
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    for (std::size_t j = 0; j < 4; ++j)
        for (std::size_t i = 0; i < 4; ++i) {
            const double c_m = control_m_[static_cast<std::size_t>(
                index(s.column + static_cast<int>(i), s.row + static_cast<int>(j)))];
            sum += c_m / knot_m * Eigen::Vector2d(along_slope[i] * across[j], along[i] * across_slope[j]);
        }
    return {s.beyond_x ? 0 : sum.x(), s.beyond_y ? 0 : sum.y()};
}

}  // namespace loopline::simulation
