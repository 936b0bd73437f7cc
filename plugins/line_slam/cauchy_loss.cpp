#include "line_slam/cauchy_loss.h"

#include <cmath>

namespace loopline::line_slam {
namespace {
constexpr double no_loss = 50;  // half the squared scale from which on the factor is 1 to a thousandth
}  // namespace

double CauchyLoss::operator()(double squared) const {
    return scale2_ * std::log1p(squared / scale2_);
}

double CauchyLoss::information_factor() const {
    // The squared norm has density exp(-x / 2) / 2. With k = scale^2 / 2: E[w] = k e^k E1(k), and by parts
    // E[w^2] = k (1 - E[w]); A = E[w + x w'] = E[w^2], B = E[w^2 x] / 2 = k (E[w] - E[w^2]).
    const double k = 0.5 * scale2_;
    if (k > no_loss) return 1;
    const double mean_weight = -k * std::exp(k) * std::expint(-k);
    const double A = k * (1 - mean_weight), B = k * (mean_weight - A);
    return A * A / (B * mean_weight);
}

}  // namespace loopline::line_slam
