/// Natural cubic splines through values at whole numbers.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace loopline::simulation {

/// Value is a vector with + - and a factor. Exact at the knots; two continuous derivatives.
template <class Value>
class CubicSpline {
 public:
    /// Two values at least.
    explicit CubicSpline(std::vector<Value> values) : values_(std::move(values)), curvatures_(values_) {
        // c[i-1] + 4 c[i] + c[i+1] = 6 (v[i-1] - 2 v[i] + v[i+1]), c = 0 at both ends: elimination from the
        // front.
        const std::size_t n = values_.size();
        std::vector<double> pivots(n, 1);
        curvatures_.front() = curvatures_.back() = 0.0 * values_.front();
        for (std::size_t i = 1; i + 1 < n; ++i) {
            const double factor = i > 1 ? 1 / pivots[i - 1] : 0;
            pivots[i] = 4 - factor;
            const Value right = 6.0 * (values_[i - 1] - 2.0 * values_[i] + values_[i + 1]);
            curvatures_[i] = right - factor * curvatures_[i - 1];
        }
        for (std::size_t i = n - 1; i-- > 1;) {
            const Value next = curvatures_[i + 1];
            curvatures_[i] = (1 / pivots[i]) * (curvatures_[i] - next);
        }
    }

    /// Beyond the ends the end pieces go on.
    Value at(double u) const {
        const double last = static_cast<double>(values_.size() - 2);
        const double begin = std::clamp(static_cast<double>(static_cast<long long>(u)), 0.0, last);
        const auto i = static_cast<std::size_t>(begin);
        const double b = u - begin, a = 1 - b;
        return a * values_[i] + b * values_[i + 1] + ((a * a * a - a) / 6) * curvatures_[i] +
               ((b * b * b - b) / 6) * curvatures_[i + 1];
    }

 private:
    std::vector<Value> values_, curvatures_;
};

}  // namespace loopline::simulation
