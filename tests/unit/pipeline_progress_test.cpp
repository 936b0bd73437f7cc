/// The progress line fits into any terminal, so that it rewrites itself and never wraps.
#include <gtest/gtest.h>

#include <algorithm>

#include "pipeline/progress.h"

using namespace loopline;

TEST(ProgressText, tells_what_fits) {
    EXPECT_EQ(progress_text("estimating", 0.71, 12.3, 3522, 80),
              "estimating:  71 %, 13 s left, 3522 x real time");
    EXPECT_EQ(progress_text("estimating", 0.71, 12.3, 3522, 40), "estimating:  71 %, 13 s left");
    EXPECT_EQ(progress_text("estimating", 0.71, 12.3, 3522, 20), "estimating:  71 %");
}

TEST(ProgressText, leaves_room_for_an_echoed_interrupt_in_any_width) {
    for (const double real_time_factor : {0.01, 1e3, 1e300})
        for (std::size_t columns = 0; columns < 400; ++columns) {
            const auto text = progress_text("drawing maps", 1, 1e12, real_time_factor, columns);
            EXPECT_LE(text.size() + std::min<std::size_t>(columns, 3), columns);
        }
}
