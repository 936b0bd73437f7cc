/// What do the parts of matching on a grid cost, and what does branch and bound save? Random rooms, beside
/// one alignment of MRPT's CICP in the same run. Prints tables; takes no arguments.
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/slam/CICP.h>

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <functional>
#include <vector>

#include "grid_map/refinement.h"
#include "grid_map/search.h"
#include "property/grid_map_world.h"

using namespace loopline;
using namespace loopline::grid_map;
using grid_map_world::Sensor;

namespace {

double cpu_s() {
    timespec t{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

double median(std::vector<double> values) {
    std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2),
                     values.end());
    return values[values.size() / 2];
}

double microseconds(const std::function<void()>& work) {
    const double start = cpu_s();
    work();
    return (cpu_s() - start) * 1e6;
}

/// A room as ten scans drew it, and one more scan of it.
struct Scene {
    lines_world::World world;
    ScanGrid grid{{}};
    std::vector<Frame> frames;
    std::vector<Pose2> poses;
    PlanarScan scan;
    Pose2 T_map_base;
};

std::vector<Scene> scenes(const Sensor& sensor, int count) {
    std::mt19937_64 random(5);
    std::vector<Scene> all(static_cast<std::size_t>(count));
    for (int k = 0; k < count; ++k) {
        Scene& s = all[static_cast<std::size_t>(k)];
        s.world = lines_world::random_world(random, 4 + k % 5, k % 4);
        for (int i = 0; i < 10; ++i) {
            s.poses.push_back(grid_map_world::random_pose(random, 0.5));
            s.frames.push_back(grid_map_world::frame_at(s.world, s.poses.back(), sensor, random));
            s.grid.insert(s.frames.back(), s.poses.back());
        }
        s.T_map_base = grid_map_world::random_pose(random, 0.5);
        s.scan = grid_map_world::scan_at(s.world, s.T_map_base, sensor, random);
    }
    return all;
}

// ---- Search
// -------------------------------------------------------------------------------------------------------

void compare_searches() {
    std::printf(
        "Search: 40 random rooms, 541 beams 270 deg, 1 cm; cells of 5 cm, 0.25 deg. The centre is off by up "
        "to half of\n"
        "the window. Milliseconds: median; ratio: of the sums. With a prior: sigma is a third of the "
        "window.\n\n"
        "%-34s %7s %12s %12s %8s %8s\n",
        "window", "points", "exhaustive", "bounded", "ratio", "least");
    struct Setup {
        const char* name;
        double half_m, half_deg;
        std::size_t points;
        bool prior;
    };
    const auto all = scenes({541, 1.5 * M_PI, {0.2, 0, 0}, 0.01}, 40);
    for (const Setup& setup :
         {Setup{"+-1 m, +-10 deg", 1, 10, 60, false}, Setup{"+-1 m, +-10 deg", 1, 10, 150, false},
          Setup{"+-1 m, +-10 deg", 1, 10, 400, false}, Setup{"+-1 m, +-10 deg, prior", 1, 10, 150, true},
          Setup{"+-2 m, +-20 deg", 2, 20, 60, false}, Setup{"+-2 m, +-20 deg", 2, 20, 150, false},
          Setup{"+-2 m, +-20 deg, prior", 2, 20, 150, true}}) {
        std::mt19937_64 random(6);
        std::vector<double> exhaustive, bounded, ratios;
        double sum_exhaustive = 0, sum_bounded = 0;
        const std::size_t few = setup.half_m > 1 ? 8 : 20;
        for (std::size_t k = 0; k < few; ++k) {
            const Scene& s = all[k];
            Frame frame;
            make_frame(s.scan, {}, {}, frame);
            const auto points = search_points(frame, setup.points);
            SearchWindow window;
            window.T_map_center = s.T_map_base * grid_map_world::random_pose(random, setup.half_m / 2,
                                                                             setup.half_deg / 2 * M_PI / 180);
            window.cells_x = window.cells_y = static_cast<int>(setup.half_m / 0.05);
            window.headings = static_cast<int>(setup.half_deg / 0.25);
            if (setup.prior) {
                window.sigma_x_m = window.sigma_y_m = setup.half_m / 3;
                window.sigma_phi_rad = setup.half_deg / 3 * M_PI / 180;
            }
            std::optional<SearchResult> best, same;
            exhaustive.push_back(microseconds([&] { best = exhaustive_search(s.grid, points, window); }));
            std::vector<double> passes;
            for (int pass = 0; pass < 5; ++pass)
                passes.push_back(microseconds([&] { same = branch_and_bound(s.grid, points, window); }));
            bounded.push_back(median(passes));
            if (best->score != same->score) std::printf("they differ\n");
            ratios.push_back(exhaustive.back() / bounded.back());
            sum_exhaustive += exhaustive.back();
            sum_bounded += bounded.back();
        }
        std::printf("%-34s %7zu %12.2f %12.3f %8.0f %8.0f\n", setup.name, setup.points,
                    median(exhaustive) / 1e3, median(bounded) / 1e3, sum_exhaustive / sum_bounded,
                    *std::min_element(ratios.begin(), ratios.end()));
    }
}

// ---- Steps of a match
// -------------------------------------------------------------------------------------------------------

mrpt::maps::CSimplePointsMap points_of(const PlanarScan& scan) {
    mrpt::maps::CSimplePointsMap map;
    for (std::size_t i = 0; i < scan.size(); ++i)
        if (scan.has_return(i)) {
            const Eigen::Vector2d p = scan.T_base_sensor * scan.point_sensor_m(i);
            map.insertPoint(static_cast<float>(p.x()), static_cast<float>(p.y()), 0);
        }
    return map;
}

/// As MRPT's icp-slam_demo_classic.ini sets it; `every`: of the points, one takes part.
mrpt::slam::CICP::TConfigParams icp_slam_settings(unsigned every) {
    mrpt::slam::CICP::TConfigParams settings;
    settings.maxIterations = 80;
    settings.thresholdDist = 0.3;
    settings.thresholdAng = 5 * M_PI / 180;
    settings.ALFA = 0.8;
    settings.smallestThresholdDist = 0.05;
    settings.corresponding_points_decimation = every;
    return settings;
}

struct Error {
    std::vector<double> m, deg;
    void add(const Pose2& found, const Pose2& truth) {
        m.push_back((found.translation() - truth.translation()).norm());
        deg.push_back(std::abs(wrap_to_pi(found.phi_rad - truth.phi_rad)) * 180 / M_PI);
    }
};

void compare_steps() {
    std::printf(
        "\nSteps, 100 random rooms, 1 cm of noise, microseconds per scan, median. Match: search of 60 points "
        "in +-0.3 m,\n"
        "+-5 deg (0.5 deg a step) and refinement against the map of ten scans, from 10 cm and 2 deg off; "
        "CICP: against one\n"
        "scan, from the same start, MRPT's demo settings with every fifth point, and with all. Errors in mm "
        "and deg, median.\n\n"
        "%-10s %7s %7s %9s %7s %7s %6s %6s %8s %6s %6s %8s %6s %6s\n",
        "beams", "frame", "insert", "remove+s", "refine", "match", "mm", "deg", "CICP", "mm", "deg",
        "CICP all", "mm", "deg");
    for (const auto& [beams, aperture] :
         {std::pair<std::size_t, double>{180, M_PI}, {541, 1.5 * M_PI}, {1081, 1.5 * M_PI}}) {
        auto all = scenes({beams, aperture, {0.2, 0, 0}, 0.01}, 100);
        std::mt19937_64 random(7);
        std::vector<double> frame_us, insert_us, remove_us, refine_us, match_us, icp_us, icp_all_us;
        Error match_error, icp_error, icp_all_error;
        mrpt::slam::CICP icp(icp_slam_settings(5)), icp_all(icp_slam_settings(1));
        Frame frame;
        for (int pass = 0; pass < 3; ++pass)
            for (Scene& s : all) {
                frame_us.push_back(microseconds([&] { make_frame(s.scan, {}, {}, frame); }));
                insert_us.push_back(microseconds([&] { s.grid.insert(frame, s.T_map_base); }));
                remove_us.push_back(microseconds([&] {
                    s.grid.remove(frame, s.T_map_base);
                    s.grid.settle();
                }));
                const Pose2 start = s.T_map_base * grid_map_world::random_pose(random, 0.07, 2 * M_PI / 180);
                SearchWindow window;
                window.T_map_center = start;
                window.cells_x = window.cells_y = 6;
                window.heading_step_rad = 0.5 * M_PI / 180;
                window.headings = 10;
                ScanFit fit;
                std::optional<SearchResult> found;
                const double search_us =
                    microseconds([&] { found = branch_and_bound(s.grid, search_points(frame, 60), window); });
                refine_us.push_back(microseconds([&] {
                    fit = refine(s.grid, frame, found->T_map_base, start, Eigen::Matrix3d::Zero(), {});
                }));
                match_us.push_back(search_us + refine_us.back());
                match_error.add(fit.T_map_base, s.T_map_base);
                if (pass > 0) continue;
                // A scan from where the map's first one was taken, in the frame of that.
                const auto reference = points_of(grid_map_world::scan_at(
                    s.world, s.poses[0], {beams, aperture, {0.2, 0, 0}, 0.01}, random));
                const auto current = points_of(s.scan);
                const Pose2 guess = s.poses[0].inverse() * start;
                const auto align = [&](mrpt::slam::CICP& by, std::vector<double>& us, Error& error) {
                    mrpt::slam::CICP::TReturnInfo information;
                    mrpt::poses::CPosePDF::Ptr pose;
                    us.push_back(microseconds([&] {
                        pose =
                            by.Align(&reference, &current,
                                     mrpt::poses::CPose2D(guess.x_m, guess.y_m, guess.phi_rad), information);
                    }));
                    const auto mean = pose->getMeanVal();
                    error.add(s.poses[0] * Pose2{mean.x(), mean.y(), mean.phi()}, s.T_map_base);
                };
                align(icp, icp_us, icp_error);
                align(icp_all, icp_all_us, icp_all_error);
            }
        std::printf("%-10zu %7.1f %7.1f %9.1f %7.1f %7.1f %6.2f %6.3f %8.0f %6.1f %6.3f %8.0f %6.1f %6.3f\n",
                    beams, median(frame_us), median(insert_us), median(remove_us), median(refine_us),
                    median(match_us), 1e3 * median(match_error.m), median(match_error.deg), median(icp_us),
                    1e3 * median(icp_error.m), median(icp_error.deg), median(icp_all_us),
                    1e3 * median(icp_all_error.m), median(icp_all_error.deg));
    }
}

}  // namespace

int main() {
    compare_searches();
    compare_steps();
}
