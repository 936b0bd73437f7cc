/// Where the downloaded logs are, for tests that are skipped without them.
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <string>

#include "support/built_files.h"

namespace loopline::test {

/// ${LOOPLINE_DATA}, or ../shared/data beside the source tree.
inline std::filesystem::path shared_data() {
    if (const char* named = std::getenv("LOOPLINE_DATA"); named && *named) return named;
    return std::filesystem::path(source_folder()).parent_path() / "shared/data";
}

}  // namespace loopline::test

/// Ends the test as skipped, visibly, if a file of the downloaded logs is not there.
#define NEEDS_SHARED_DATA(relative_path)                                           \
    if (!std::filesystem::exists(loopline::test::shared_data() / (relative_path))) \
    GTEST_SKIP() << (loopline::test::shared_data() / (relative_path))              \
                 << " is not there; see datasets/README.md"
