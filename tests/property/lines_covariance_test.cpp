/// The covariance of a line against Monte Carlo: what the extractor claims for one scan must be what its
/// lines scatter by over many scans of the same wall.
#include <gtest/gtest.h>

#include <string>

#include "property/lines_views.h"

using lines_world::correlation;
using lines_world::Scatter;
using lines_world::View;
using loopline::lines::Method;

namespace {

class LineCovariance : public testing::TestWithParam<View> {};

TEST_P(LineCovariance, is_what_lines_scatter_by) {
    for (const Method method : {Method::angle_threshold, Method::split_and_merge, Method::incremental}) {
        const Scatter s = lines_world::monte_carlo(GetParam(), method, 8000);
        SCOPED_TRACE(testing::Message()
                     << GetParam().name << ", method " << static_cast<int>(method) << ", found " << s.found);
        ASSERT_GT(s.found, 0.97 * s.scans);
        EXPECT_LT(std::abs(s.mean(0)), 0.15 * std::sqrt(s.scatter(0, 0))) << "bias of rho";
        EXPECT_LT(std::abs(s.mean(1)), 0.15 * std::sqrt(s.scatter(1, 1))) << "bias of alpha";
        EXPECT_NEAR(s.claimed(0, 0) / s.scatter(0, 0), 1, 0.1) << "variance of rho";
        EXPECT_NEAR(s.claimed(1, 1) / s.scatter(1, 1), 1, 0.1) << "variance of alpha";
        EXPECT_NEAR(correlation(s.claimed), correlation(s.scatter), 0.1);
    }
}

INSTANTIATE_TEST_SUITE_P(Views, LineCovariance, testing::ValuesIn(lines_world::views), [](const auto& view) {
    std::string name = view.param.name;
    for (char& c : name)
        if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
    return name;
});

}  // namespace
