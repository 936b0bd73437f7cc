/// Which directions of a motion in space the scene holds, and which it leaves free. Zhang, Kaess, Singh 2016,
/// "On degeneracy of optimization-based state estimation problems": eigenvectors of the information whose
/// eigenvalue is small are left out of the solution.
#pragma once

#include <algorithm>
#include <cmath>

#include "api/dense_algebra.h"

namespace loopline::least_squares {

class HeldDirections {
 public:
    using Vector6d = Eigen::Matrix<double, 6, 1>;
    using Matrix6d = Eigen::Matrix<double, 6, 6>;

    /// `information` on (shift, turn); a turn counts by what it moves at `range_m`. A direction that is held
    /// no better than `sigma_limit_m` is free.
    HeldDirections(const Matrix6d& information, double range_m, double sigma_limit_m)
        : least_(1 / (sigma_limit_m * sigma_limit_m)) {
        scale_ << 1, 1, 1, 1 / range_m, 1 / range_m, 1 / range_m;
        const Spectrum spectrum = spectrum_of(scale_.asDiagonal() * information * scale_.asDiagonal());
        sound_ = held_by_ = spectrum.values;
        axes_ = spectrum.vectors;
    }

    /// What of the information on a direction does not count as to whether it is held: `part` of a (shift,
    /// turn) is asked of those directions alone that are held no better than `sigma_m`.
    template <class Part>
    void without(double sigma_m, const Part& part) {
        for (Eigen::Index k = 0; k < 6; ++k)
            if (sound_[k] * sigma_m * sigma_m < 1)
                sound_[k] -= part(Vector6d(scale_.asDiagonal() * axes_.col(k)));
    }

    bool all() const { return !(sound_.minCoeff() < least_); }
    int free_count() const { return static_cast<int>((sound_.array() < least_).count()); }
    /// Standard deviation along the direction that is held least.
    double weakest_sigma_m() const { return 1 / std::sqrt(std::max(sound_.minCoeff(), 1e-6)); }
    /// That direction, of length 1 with a turn as what it moves at the range.
    Vector6d weakest_moves_m() const {
        Eigen::Index k = 0;
        sound_.minCoeff(&k);
        return axes_.col(k);
    }
    /// The same as (shift, turn).
    Vector6d weakest() const { return scale_.asDiagonal() * weakest_moves_m(); }
    /// Of a (shift, turn) onto what is held; its transpose, of an information or a gradient.
    Matrix6d projection() const {
        return scale_.asDiagonal() * axes_ * held().asDiagonal() * axes_.transpose() *
               scale_.cwiseInverse().asDiagonal();
    }
    /// Without that on the free directions.
    Matrix6d information() const {
        const Matrix6d axes = scale_.cwiseInverse().asDiagonal() * axes_;
        return axes * held().cwiseProduct(held_by_).asDiagonal() * axes.transpose();
    }

 private:
    /// 1 for a direction that is held, else 0.
    Vector6d held() const { return (sound_.array() < least_).select(Vector6d::Zero(), Vector6d::Ones()); }

    double least_;
    Vector6d scale_, held_by_, sound_;
    Matrix6d axes_;
};

}  // namespace loopline::least_squares
