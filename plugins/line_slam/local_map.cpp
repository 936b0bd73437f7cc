#include "line_slam/local_map.h"

#include <algorithm>
#include <cassert>
#include <utility>

namespace loopline::line_slam {
namespace {

/// `matrix` without rows (and columns, if `both`) first and first + 1.
Eigen::MatrixXd without(const Eigen::MatrixXd& matrix, Eigen::Index first, bool both) {
    const Eigen::Index rows = matrix.rows() - 2, cols = matrix.cols() - (both ? 2 : 0);
    Eigen::MatrixXd rest(rows, cols);
    for (Eigen::Index c = 0; c < cols; ++c) {
        const Eigen::Index from = both && c >= first ? c + 2 : c;
        rest.col(c).head(first) = matrix.col(from).head(first);
        rest.col(c).tail(rows - first) = matrix.col(from).tail(rows - first);
    }
    return rest;
}

std::vector<Eigen::Index> line_rows(const std::vector<int>& positions) {
    std::vector<Eigen::Index> rows;
    for (const int p : positions) rows.insert(rows.end(), {LocalMap::row(p), LocalMap::row(p) + 1});
    return rows;
}

}  // namespace

Compression Compression::none(Eigen::Index size) {
    return {Eigen::MatrixXd::Identity(size, size), Eigen::MatrixXd::Zero(size, size),
            Eigen::VectorXd::Zero(size)};
}

std::vector<Eigen::Index> LocalMap::rows_of(const std::vector<int>& positions) {
    std::vector<Eigen::Index> rows;
    for (Eigen::Index r = 0; r < head; ++r) rows.push_back(r);
    const auto rest = line_rows(positions);
    rows.insert(rows.end(), rest.begin(), rest.end());
    return rows;
}

LocalMap LocalMap::leave(const std::vector<int>& positions) {
    kept = positions;
    LocalMap next;
    next.origin_m = origin_m;
    for (const int p : positions) next.lines.push_back(lines[static_cast<std::size_t>(p)]);
    const auto rows = rows_of(positions);
    next.P = P(rows, rows);
    next.since_entered = Compression::none(next.P.rows());
    return next;
}

LocalMap::Guests LocalMap::send_on(const std::vector<int>& positions) {
    Guests guests;
    for (const int p : positions) guests.ids.push_back(lines[static_cast<std::size_t>(p)]);
    const auto columns = line_rows(positions);
    guests.with_y0 = P(rows_of(kept), columns);
    guests.P = P(columns, columns);
    kept.insert(kept.end(), positions.begin(), positions.end());
    return guests;
}

Eigen::VectorXd LocalMap::welcome(const Guests& guests) {
    const Eigen::Index n = P.rows(), n0 = since_entered.psi.rows(), g = guests.P.rows();
    auto& [phi, psi, chi] = since_entered;
    const Eigen::MatrixXd with_y = phi * guests.with_y0;
    const Eigen::MatrixXd psi_with_y0 = psi * guests.with_y0;
    const Eigen::VectorXd change = guests.with_y0.transpose() * chi;

    P.conservativeResize(n + g, n + g);
    P.topRightCorner(n, g) = with_y;
    P.bottomLeftCorner(g, n) = with_y.transpose();
    P.bottomRightCorner(g, g) = guests.P;
    P.bottomRightCorner(g, g).noalias() -= guests.with_y0.transpose() * psi_with_y0;
    // With the guests as the last part of y0 and of y: phi' = [phi 0; -P_gy0 psi, I].
    phi.conservativeResize(n + g, n0 + g);
    phi.topRightCorner(n, g).setZero();
    phi.bottomLeftCorner(g, n0) = -psi_with_y0.transpose();
    phi.bottomRightCorner(g, g).setIdentity();
    psi.conservativeResize(n0 + g, n0 + g);
    psi.topRightCorner(n0, g).setZero();
    psi.bottomRows(g).setZero();
    chi.conservativeResize(n0 + g);
    chi.tail(g).setZero();
    lines.insert(lines.end(), guests.ids.begin(), guests.ids.end());
    for (std::size_t k = 0; k < guests.ids.size(); ++k)
        shift_line(static_cast<int>(lines.size() - guests.ids.size() + k), guests.lever_m[k]);
    return change;
}

/// p = p^ + t + theta z x (p^ - origin): t' = t + theta z x (origin' - origin).
void LocalMap::turn_head(const Eigen::Vector2d& way_m) {
    Eigen::MatrixXd& phi = since_entered.phi;
    for (const auto& [row, factor] : {std::pair{0, -way_m.y()}, std::pair{1, way_m.x()}}) {
        P.row(row) += factor * P.row(2);
        P.col(row) += factor * P.col(2);
        phi.row(row) += factor * phi.row(2);
    }
}

/// rho' = rho - n . way: drho' = drho - dalpha tangent . way.
void LocalMap::shift_line(int position, double lever_m) {
    Eigen::MatrixXd& phi = since_entered.phi;
    const Eigen::Index r = row(position);
    P.row(r) -= lever_m * P.row(r + 1);
    P.col(r) -= lever_m * P.col(r + 1);
    phi.row(r) -= lever_m * phi.row(r + 1);
}

void LocalMap::remove(int position) {
    assert(std::find(kept.begin(), kept.end(), position) == kept.end());
    P = without(P, row(position), true);
    since_entered.phi = without(since_entered.phi, row(position), false);
    lines.erase(lines.begin() + position);
    for (int& k : kept) k -= k > position;
}

Compression joined(const LocalMap& first, const Compression& second) {
    const Compression& a = first.since_entered;
    const Eigen::MatrixXd to_second = a.phi(LocalMap::rows_of(first.kept), Eigen::all);
    Compression both;
    both.phi.noalias() = second.phi * to_second;
    both.psi = a.psi;
    both.psi.noalias() += to_second.transpose() * (second.psi * to_second);
    both.chi = a.chi + to_second.transpose() * second.chi;
    return both;
}

}  // namespace loopline::line_slam
