/// The finished cloud of a small street that a receiver has placed on the Earth.
#pragma once

#include "support/street_log.h"

namespace loopline::test {

inline std::string run_ini(const std::string& log, const std::string& sections) {
    return "[run]\nrawlog = " + log + "\n" + sections +
           "\n[outputs]\nsnapshots = false\nreport = false\nstates_mb = 0\n";
}

/// A run directory, made once a process from placed_street_log().
inline std::string placed_street_map() {
    static const TemporaryFolder folder;
    static const std::string map = [] {
        const std::string out = (folder / "map").string();
        const std::string ini = folder.write(
            "map.ini",
            run_ini(placed_street_log(),
                    "modules = lidar_mapping fusion\nmaps = final_cloud_map\ntrajectory = fusion"));
        EXPECT_EQ(run_loopline({"run", ini, "--out", out, "--quiet"}).exit_code, 0);
        return out;
    }();
    return map;
}

}  // namespace loopline::test
