#include "grid_map/refinement.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>

namespace loopline::grid_map {
namespace {

/// Where the map has a surface for a return: a point of it, and its normal.
struct Correspondence {
    Eigen::Vector2d p_map_m, normal_map;
    bool found = false;
};

/// Pieces of surface around a return, of which the nearest one and those that continue it are averaged.
class NearbySurfaces {
 public:
    explicit NearbySurfaces(double reach2) : nearest2_(reach2) {}

    /// A piece at `dx`, `dy` from the return.
    void add(float dx, float dy, float nx, float ny, float weight) {
        if (count_ == pieces_.size()) return;  // plenty
        const float d2 = dx * dx + dy * dy;
        if (d2 < nearest2_) {
            nearest2_ = d2;
            nearest_ = count_;
        }
        pieces_[count_++] = {dx, dy, nx, ny, d2, weight};
    }

    /// A piece counts less the farther it is than the nearest one, over a cell: as SurfaceIndex::nearest does
    /// over the spacing of points.
    Correspondence average(const Eigen::Vector2d& p_map_m, double cell_m) const {
        Correspondence c;
        if (nearest_ == none) return c;
        const Piece& nearest = pieces_[nearest_];
        float sum_x = 0, sum_y = 0, sum_nx = 0, sum_ny = 0, sum_w = 0;
        for (std::size_t k = 0; k < count_; ++k) {
            const Piece& q = pieces_[k];
            if (q.nx * nearest.nx + q.ny * nearest.ny < 0.8F) continue;
            // Falls like a Gaussian, and is quick to compute.
            const float part = std::max(0.0F, 1 - (q.d2 - nearest.d2) * 0.125F),
                        w = q.weight * part * part * part * part;
            sum_x += w * q.dx;
            sum_y += w * q.dy;
            sum_nx += w * q.nx;
            sum_ny += w * q.ny;
            sum_w += w;
        }
        c.found = true;
        c.p_map_m = p_map_m + Eigen::Vector2d(sum_x, sum_y) * (cell_m / static_cast<double>(sum_w));
        c.normal_map = Eigen::Vector2d(sum_nx, sum_ny).normalized();
        return c;
    }

 private:
    struct Piece {
        float dx, dy, nx, ny, d2, weight;
    };
    static constexpr std::size_t none = ~std::size_t{0};
    std::array<Piece, 64> pieces_;
    std::size_t count_ = 0, nearest_ = none;
    float nearest2_;
};

/// Surfaces of a grid: one piece a cell.
class GridSurfaces {
 public:
    GridSurfaces(const ScanGrid& grid, double reach_m)
        : grid_(grid),
          reach_cells_(reach_m / grid.cell_m()),
          radius_(std::clamp(static_cast<int>(std::ceil(reach_cells_ - 0.5)), 1, 3)) {}

    Correspondence at(const Eigen::Vector2d& p_map_m, const Eigen::Vector2d& normal) const {
        const CellIndex cell = grid_.cell_of(p_map_m.x(), p_map_m.y());
        const auto px = static_cast<float>(p_map_m.x() / grid_.cell_m() - cell.x),
                   py = static_cast<float>(p_map_m.y() / grid_.cell_m() - cell.y),
                   nx = static_cast<float>(normal.x()), ny = static_cast<float>(normal.y());
        NearbySurfaces nearby(reach_cells_ * reach_cells_);
        grid_.surfaces().visit_window(
            cell.x - radius_, cell.y - radius_, cell.x + radius_, cell.y + radius_,
            [&](int x, int y, const Surface& s) {
                if (s.returns == 0) return;
                const auto returns = static_cast<float>(s.returns), snx = static_cast<float>(s.sum_nx),
                           sny = static_cast<float>(s.sum_ny);
                const float facing = nx * snx + ny * sny, length2 = snx * snx + sny * sny;
                // None where normals cancel: at an edge, or where hardly a return knows its normal.
                if (facing <= 0 || facing * facing < 0.5F * length2 ||
                    length2 < 0.09F * 1048576 * returns * returns)
                    return;
                const float per = 1 / (1024 * returns), per_length = 1 / std::sqrt(length2);
                nearby.add(static_cast<float>(x - cell.x) + static_cast<float>(s.sum_x) * per - px,
                           static_cast<float>(y - cell.y) + static_cast<float>(s.sum_y) * per - py,
                           snx * per_length, sny * per_length, std::min(returns, 20.0F));
            });
        return nearby.average(p_map_m, grid_.cell_m());
    }
    static constexpr bool has_rough_normals() { return false; }

 private:
    const ScanGrid& grid_;
    double reach_cells_;
    int radius_;
};

/// Surfaces of a few frames: one piece a return.
class IndexedSurfaces {
 public:
    IndexedSurfaces(const SurfaceIndex& index, double reach_m)
        : index_(index), reach_m_(static_cast<float>(reach_m)) {}

    Correspondence at(const Eigen::Vector2d& p_map_m, const Eigen::Vector2d& normal) const {
        const SurfaceIndex::Nearby nearby =
            index_.nearest(p_map_m.x(), p_map_m.y(), static_cast<float>(normal.x()),
                           static_cast<float>(normal.y()), reach_m_);
        Correspondence c;
        if (!nearby.found) return c;
        c.found = true;
        c.p_map_m = p_map_m + Eigen::Vector2d(nearby.dx_m, nearby.dy_m);
        c.normal_map = Eigen::Vector2d(nearby.nx, nearby.ny).normalized();
        return c;
    }
    bool has_rough_normals() const { return index_.has_rough_normals(); }

 private:
    const SurfaceIndex& index_;
    float reach_m_;
};

struct NormalEquations {
    Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
    /// The same by the map's normals on one side and the scan's own on the other. What noise turns the
    /// normals of a wall by looks like information along it; both have such errors, but not the same ones, so
    /// that here they cancel.
    Eigen::Matrix3d by_both_normals = Eigen::Matrix3d::Zero();
    Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
    double squares = 0;
    int used = 0, of = 0;
};

/// Residual of a return: distance from its surface, e = n (T p - q); d e / d (x, y, phi) = (n, n . R' p). n
/// is the map's; where steps from row to row of cells turn that one, it is the scan's.
template <class Surfaces>
NormalEquations linearise(const Surfaces& surfaces, const Frame& frame, const std::vector<float>& worth,
                          const Pose2& T, const RefinementSettings& settings) {
    NormalEquations sums;
    const double c = std::cos(T.phi_rad), s = std::sin(T.phi_rad),
                 per_sigma2 = 1 / (settings.sigma_m * settings.sigma_m);
    for (std::size_t i = 0; i < frame.points.size(); ++i) {
        const SurfacePoint& point = frame.points[i];
        if (!point.has_normal()) continue;
        ++sums.of;
        const double px = point.p_base_m.x(), py = point.p_base_m.y(), nx = point.normal_base.x(),
                     ny = point.normal_base.y();
        const Eigen::Vector2d turned(c * px - s * py, s * px + c * py),
            normal(c * nx - s * ny, s * nx + c * ny);
        const Eigen::Vector2d p_map(T.x_m + turned.x(), T.y_m + turned.y());
        const Correspondence surface = surfaces.at(p_map, normal);
        if (!surface.found) continue;
        const Eigen::Vector2d& across = surfaces.has_rough_normals() ? normal : surface.normal_map;
        const double e = across.dot(p_map - surface.p_map_m);
        // Cauchy's weight: what is three sigmas off counts a tenth.
        const double w = static_cast<double>(worth[i]) * per_sigma2 / (1 + e * e * per_sigma2);
        // The arm of a turn ends on the surface, not at the return: noise that moves a return along a
        // slanting beam moves its arm too, and residuals times arms would then pull the heading to one side.
        const Eigen::Vector2d arm = surface.p_map_m - Eigen::Vector2d(T.x_m, T.y_m);
        const auto along = [&arm](const Eigen::Vector2d& n) {
            return Eigen::Vector3d(n.x(), n.y(), -n.x() * arm.y() + n.y() * arm.x());
        };
        const Eigen::Vector3d j = along(across);
        sums.information += w * j * j.transpose();
        sums.by_both_normals += w * along(surface.normal_map) * along(normal).transpose();
        sums.gradient -= w * e * j;
        sums.squares += e * e;
        ++sums.used;
    }
    return sums;
}

/// What each return is worth beside one at right angles to its wall: less where an error of the beam's angle
/// moves it away from the wall, and less where returns are so close together along a wall that they err
/// together.
void worth_of_returns(const Frame& frame, const RefinementSettings& settings, std::vector<float>& worth) {
    const auto& points = frame.points;
    worth.assign(points.size(), 1);
    const auto per_sigma2 = static_cast<float>(1 / (settings.sigma_m * settings.sigma_m)),
               sigma_angle = static_cast<float>(settings.sigma_angle_rad),
               per_correlation =
                   static_cast<float>(settings.correlation_m > 0 ? 1 / settings.correlation_m : 1e9);
    float before_m = -1;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const Eigen::Vector2f beam = points[i].p_base_m - frame.p_base_sensor_m;
        const float range2 = beam.squaredNorm(), across = points[i].normal_base.dot(beam);
        const float sideways_m = sigma_angle * std::sqrt(std::max(0.0F, range2 - across * across));
        const float after_m =
            i + 1 < points.size() ? (points[i + 1].p_base_m - points[i].p_base_m).norm() : -1;
        const float spacing_m = before_m < 0 ? after_m : after_m < 0 ? before_m : (before_m + after_m) / 2;
        worth[i] = 1 / (1 + sideways_m * sideways_m * per_sigma2);
        if (spacing_m >= 0) worth[i] *= std::min(1.0F, spacing_m * per_correlation);
        before_m = after_m;
    }
}

/// The information that is left: nothing in directions where chance made it negative.
Eigen::Matrix3d without_noise_of_normals(const Eigen::Matrix3d& by_both_normals) {
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen;
    eigen.computeDirect(0.5 * (by_both_normals + by_both_normals.transpose()));
    return eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0).asDiagonal() *
           eigen.eigenvectors().transpose();
}

template <class Surfaces>
ScanFit refined(const Surfaces& surfaces, const Frame& frame, const Pose2& T_map_start,
                const Pose2& T_map_prior, const Eigen::Matrix3d& prior_information,
                const RefinementSettings& settings) {
    ScanFit result;
    result.T_map_base = T_map_start;
    thread_local std::vector<float> worth;
    worth_of_returns(frame, settings, worth);
    NormalEquations sums;
    for (int i = 0; i < settings.iterations; ++i) {
        Pose2& T = result.T_map_base;
        sums = linearise(surfaces, frame, worth, T, settings);
        if (i == 3 && sums.used < settings.give_up_fit * sums.of) break;
        const Eigen::Vector3d off(T_map_prior.x_m - T.x_m, T_map_prior.y_m - T.y_m,
                                  wrap_to_pi(T_map_prior.phi_rad - T.phi_rad));
        const Eigen::Matrix3d information = sums.information + prior_information;
        const Eigen::LDLT<Eigen::Matrix3d> solver(information + 1e-6 * Eigen::Matrix3d::Identity());
        const Eigen::Vector3d step = solver.solve(sums.gradient + prior_information * off);
        if (!step.allFinite()) break;
        T = {T.x_m + step.x(), T.y_m + step.y(), wrap_to_pi(T.phi_rad + step.z())};
        if (step.head<2>().norm() < settings.enough_m && std::abs(step.z()) < settings.enough_rad) {
            result.converged = true;
            break;
        }
    }
    result.information = without_noise_of_normals(sums.by_both_normals);
    // Where its own optimum is, stays; how much it draws towards it, is as much as is known.
    const Eigen::LDLT<Eigen::Matrix3d> solver(sums.information + 1e-6 * Eigen::Matrix3d::Identity());
    result.gradient = result.information * solver.solve(sums.gradient);
    result.used = sums.used;
    result.fit = sums.of > 0 ? static_cast<double>(sums.used) / sums.of : 0;
    result.rms_m = sums.used > 0 ? std::sqrt(sums.squares / sums.used) : 0;
    return result;
}

}  // namespace

ScanFit refine(const ScanGrid& grid, const Frame& frame, const Pose2& T_map_start, const Pose2& T_map_prior,
               const Eigen::Matrix3d& prior_information, const RefinementSettings& settings) {
    return refined(GridSurfaces(grid, settings.reach_m), frame, T_map_start, T_map_prior, prior_information,
                   settings);
}

ScanFit refine(const SurfaceIndex& map, const Frame& frame, const Pose2& T_map_start,
               const Pose2& T_map_prior, const Eigen::Matrix3d& prior_information,
               const RefinementSettings& settings) {
    return refined(IndexedSurfaces(map, settings.reach_m), frame, T_map_start, T_map_prior, prior_information,
                   settings);
}

namespace {

/// Directions of motion by how well a scan holds them, weakest first. A heading counts by what it moves at
/// the mean range, so that all three have one unit.
struct HeldDirections {
    HeldDirections(const ScanFit& fit, double mean_range_m) : scale(1, 1, 1 / std::max(mean_range_m, 0.1)) {
        eigen.compute(scale.asDiagonal() * fit.information * scale.asDiagonal());
    }
    bool is_free(int k, double sigma_limit_m) const {
        return eigen.eigenvalues()[k] < 1 / (sigma_limit_m * sigma_limit_m);
    }
    Eigen::Vector3d scale;
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen;
};

}  // namespace

Degeneracy degeneracy(const ScanFit& fit, double mean_range_m, double sigma_limit_m) {
    const HeldDirections held(fit, mean_range_m);
    Degeneracy d;
    for (int k = 0; k < 3; ++k) d.free_directions += held.is_free(k, sigma_limit_m);
    d.weakest_sigma_m = 1 / std::sqrt(std::max(held.eigen.eigenvalues()[0], 1e-12));
    d.direction_rad = std::atan2(held.eigen.eigenvectors()(1, 0), held.eigen.eigenvectors()(0, 0));
    return d;
}

void forget_free_directions(ScanFit& fit, const Pose2& T_map_prior, double mean_range_m,
                            double sigma_limit_m) {
    const HeldDirections held(fit, mean_range_m);
    Eigen::Matrix3d onto_held = Eigen::Matrix3d::Zero();  // in the scaled coordinates
    for (int k = 0; k < 3; ++k)
        if (!held.is_free(k, sigma_limit_m))
            onto_held += held.eigen.eigenvectors().col(k) * held.eigen.eigenvectors().col(k).transpose();
    const Eigen::Matrix3d project =
        held.scale.cwiseInverse().asDiagonal() * onto_held * held.scale.asDiagonal();
    fit.information = project * fit.information * project.transpose();
    fit.gradient = project * fit.gradient;
    Pose2& T = fit.T_map_base;
    const Eigen::Vector3d off(T_map_prior.x_m - T.x_m, T_map_prior.y_m - T.y_m,
                              wrap_to_pi(T_map_prior.phi_rad - T.phi_rad));
    const Eigen::Vector3d free = off - project.transpose() * off;
    T = {T.x_m + free.x(), T.y_m + free.y(), wrap_to_pi(T.phi_rad + free.z())};
}

}  // namespace loopline::grid_map
