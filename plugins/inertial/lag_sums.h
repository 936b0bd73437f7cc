/// Running sums from which gyro and odometry are correlated at every delay between the two.
#pragma once

#include <Eigen/Core>
#include <optional>

namespace loopline::inertial {

struct LagSums {
    static constexpr int reach = 50;  ///< lags to either side, in cells of the grid
    static constexpr int lags = 2 * reach + 1;
    using Table = Eigen::Array<double, lags, 3>;  ///< by lag and by axis of the gyro

    double n = 0;
    double r = 0, rr = 0;  ///< odometry's rate and its square
    Table g = Table::Zero(), gg = Table::Zero(), rg = Table::Zero();

    void add(double odometry_radps, const Table& gyro_radps) {
        n += 1;
        r += odometry_radps;
        rr += odometry_radps * odometry_radps;
        g += gyro_radps;
        gg += gyro_radps.square();
        rg += odometry_radps * gyro_radps;
    }
    void operator+=(const LagSums& more) {
        n += more.n;
        r += more.r;
        rr += more.rr;
        g += more.g;
        gg += more.gg;
        rg += more.rg;
    }

    /// Sums about the means.
    double odometry_squares() const { return rr - r * r / n; }
    Table gyro_squares() const { return gg - g.square() / n; }
    Table products() const { return rg - r * g / n; }
    /// -1 .. 1; 0 where one of the two does not change at all.
    Table correlation() const {
        const Table squares = odometry_squares() * gyro_squares();
        return (squares > 1e-20 * n * n).select(products() / squares.max(1e-300).sqrt(), 0);
    }
};

/// The lag, in whole cells, at which |correlation| is greatest; positive where the gyro comes later.
struct LagPeak {
    int axis = 2;  ///< of the gyro
    int cells = 0;
    int half_width = 0;  ///< so far to either side the correlation stays near its greatest
    Eigen::Array3d correlation = Eigen::Array3d::Zero();  ///< of each axis there
    Eigen::Vector3d slope = Eigen::Vector3d::Zero();      ///< of each axis: gyro = slope * odometry + offset
    Eigen::Vector3d offset_radps = Eigen::Vector3d::Zero();
};
LagPeak find_peak(const LagSums& sums);

/// Squares of gyro - slope * odometry - offset as a parabola of x = lag - `middle`, in cells: constant +
/// slope x + curvature x^2 /
/// 2. By least squares over the peak's width.
struct LagParabola {
    double slope = 0, curvature = 0;
};
/// `middle` is within `reach` of 0 by a few cells at least.
LagParabola parabola_around(int middle, const LagSums& sums, const LagPeak& peak);

/// The middle around which the parabola of `sums` has its top within a cell; none if the peak is so near the
/// ends of the table that it may lie beyond, or too noisy to have a top.
std::optional<int> middle_of_peak(const LagSums& sums, const LagPeak& peak);

}  // namespace loopline::inertial
