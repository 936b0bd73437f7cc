/// The loss under which observations of lines enter the least squares: whoever contradicts all others counts
/// for little.
#pragma once

namespace loopline::line_slam {

/// Of the squared norm of a whitened residual in two dimensions: scale^2 log(1 + x / scale^2).
class CauchyLoss {
 public:
    explicit CauchyLoss(double scale) : scale2_(scale * scale) {}

    double operator()(double squared) const;
    /// Its derivative: what the observation's information is multiplied by.
    double weight(double squared) const { return 1 / (1 + squared / scale2_); }
    /// Honest normal residuals are weighted down as well, though what they tell is hardly less: the sum of
    /// weighted informations is too small by E[w] and the estimate scatters by B / A^2 with A = E[d(w r)/dr],
    /// B = E[w^2 r r'] (Huber 1981, section 6.3). The factor that makes the one the inverse of the other.
    double information_factor() const;

 private:
    double scale2_;
};

}  // namespace loopline::line_slam
