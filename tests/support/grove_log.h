/// A log of a drive among trees: wheels at 10 Hz, and what a sensor with a mount says of trunks at 5 Hz.
#pragma once

#include <gtest/gtest.h>

#include <fstream>
#include <iomanip>
#include <string>

#include "support/grove.h"
#include "support/run_program.h"

namespace loopline::test {

/// 80 m of way in 32 s; imported once a process from tables, the truth (TUM) beside it.
inline std::string grove_log() {
    static const TemporaryFolder folder;
    static const std::string log = [] {
        using namespace landmark_odometry::test;
        GroveSettings settings;
        settings.turn_scale = 0.9;
        Grove grove(settings, 4);
        std::ofstream wheels(folder / "wheels.csv"), trunks(folder / "trunks.csv"),
            truth(folder / "truth.csv");
        for (auto* table : {&wheels, &trunks, &truth}) *table << std::setprecision(9);
        wheels << "t,x,y,yaw\n";
        trunks << "t,range,bearing\n";
        truth << "t,x,y,yaw\n";
        Pose2 T_odom_base;
        constexpr double ahead_m = 0.3, left_m = 0.1;  // of the sensor, which looks to the left
        for (int k = 0; grove.way_m() < 80; ++k) {
            const double t_s = 100 + 0.2 * k;
            if (k > 0) T_odom_base = T_odom_base * exp_se2(grove.drive());
            wheels << t_s << ',' << T_odom_base.x_m << ',' << T_odom_base.y_m << ',' << T_odom_base.phi_rad
                   << '\n';
            const Pose2 T = grove.T_map_base();
            truth << t_s << ',' << T.x_m << ',' << T.y_m << ',' << T.phi_rad << '\n';
            for (const auto& seen : grove.look()) {
                const Eigen::Vector2d p_m = seen.p_base_m - Eigen::Vector2d(ahead_m, left_m);
                trunks << t_s << ',' << p_m.norm() << ',' << std::atan2(p_m.y(), p_m.x()) - M_PI / 2 << '\n';
            }
        }
        for (auto* table : {&wheels, &trunks, &truth}) table->close();
        const std::string map = folder.write(
            "columns.ini",
            "[wheels]\nkind = odometry\nfile = wheels.csv\ntime = t\nx = x\ny = y\nyaw = yaw in rad\n"
            "[trunks]\nkind = landmarks\nfile = trunks.csv\ntime = t\nrange = range\nbearing = bearing in "
            "rad\n"
            "x_m = 0.3\ny_m = 0.1\nyaw_deg = 90\n"
            "[truth]\nkind = reference\nfile = truth.csv\ntime = t\nx = x\ny = y\nyaw = yaw in rad\n");
        const std::string out = (folder / "grove.rawlog").string();
        const auto result =
            run_loopline({"import", "csv", folder.path().string(), "--columns", map, "--out", out});
        EXPECT_EQ(result.exit_code, 0) << result.err;
        return out;
    }();
    return log;
}

}  // namespace loopline::test
