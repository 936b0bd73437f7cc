/// Which line extraction method, and what does it cost? The three methods on random polygon worlds with truth
/// and on real logs, beside one scan alignment of MRPT's CICP in the same run. Prints tables; takes no
/// arguments.
#include <mrpt/io/CFileGZInputStream.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/serialization/CArchive.h>
#include <mrpt/slam/CICP.h>

#include <Eigen/LU>
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "lines/line_extractor.h"
#include "property/lines_truth.h"
#include "property/lines_views.h"
#include "property/lines_world.h"
#include "support/built_files.h"

using namespace loopline;
using namespace loopline::lines;
using mrpt::obs::CObservation2DRangeScan;

namespace {

constexpr const char* method_names[] = {"angle_threshold", "split_and_merge", "incremental"};

double cpu_s() {
    timespec t{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

double median(std::vector<double> values) {
    if (values.empty()) return 0;
    std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2),
                     values.end());
    return values[values.size() / 2];
}

/// Median over nine passes of the CPU time per scan.
double microseconds_per_scan(LineExtractor& extractor, const std::vector<const PlanarScan*>& scans) {
    LineSegments segments;
    std::vector<double> passes;
    for (int pass = 0; pass < 9; ++pass) {
        const double start = cpu_s();
        for (const PlanarScan* scan : scans) extractor.extract(*scan, segments);
        passes.push_back((cpu_s() - start) / static_cast<double>(scans.size()) * 1e6);
    }
    return median(passes);
}

// ---- Worlds
// -------------------------------------------------------------------------------------------------------

struct Scene {
    lines_world::World world;
    lines_world::Sensor sensor;
    lines_world::Sweep sweep;
};

std::vector<Scene> scenes(std::size_t beams, double aperture_rad, double sigma_range_m, bool pillars) {
    std::mt19937_64 random(11);
    std::uniform_real_distribution<double> unit(0, 1);
    std::vector<Scene> all(400);
    for (int k = 0; k < static_cast<int>(all.size()); ++k) {
        Scene& s = all[static_cast<std::size_t>(k)];
        s.world = lines_world::random_world(random, 4 + k % 5, k % 4);
        if (pillars)
            for (int i = 0; i < 3; ++i) {
                const double bearing = 2 * M_PI * unit(random), r = 1.5 + 2.5 * unit(random);
                s.world.circles.push_back({{r * std::cos(bearing), r * std::sin(bearing)},
                                           0.1 + 0.9 * unit(random) * unit(random)});
            }
        s.sensor.beams = beams;
        s.sensor.aperture_rad = aperture_rad;
        s.sensor.T_world_sensor = {0.5 * unit(random), 0.5 * unit(random), 2 * M_PI * unit(random)};
        s.sweep = lines_world::sweep(s.world, s.sensor);
        lines_world::add_range_noise(s.sweep, sigma_range_m, random);
    }
    return all;
}

void compare_on_worlds() {
    std::printf(
        "Random polygon worlds, 400 scans each. Recall: walls seen by 8 beams over 0.6 m that were found. "
        "False: lines on\n"
        "no wall, or off theirs by more than 5 of their own sigmas, per 100 scans. rho, alpha: rms error / "
        "claimed sigma\n"
        "(1 is honest). End: median distance of a segment's end from where the wall's visible part ends.\n\n"
        "%-34s %-16s %7s %7s %6s %6s %6s %6s %7s\n",
        "world", "method", "us/scan", "recall", "false", "split", "rho", "alpha", "end mm");
    struct Setup {
        const char* name;
        std::size_t beams;
        double aperture_rad, sigma_range_m;
        bool pillars;
    };
    for (const Setup& setup : {Setup{"181 beams 180 deg, 1 cm", 181, M_PI, 0.01, false},
                               Setup{"181 beams 180 deg, 1 cm, pillars", 181, M_PI, 0.01, true},
                               Setup{"361 beams 180 deg, 1 cm", 361, M_PI, 0.01, false},
                               Setup{"682 beams 240 deg, 3 cm", 682, 4 * M_PI / 3, 0.03, false},
                               Setup{"1081 beams 270 deg, 3 cm, pillars", 1081, 1.5 * M_PI, 0.03, true},
                               Setup{"361 beams 180 deg, 10 cm", 361, M_PI, 0.1, false}}) {
        const auto all = scenes(setup.beams, setup.aperture_rad, setup.sigma_range_m, setup.pillars);
        std::vector<const PlanarScan*> scans;
        for (const auto& s : all) scans.push_back(&s.sweep.scan);
        for (int method = 0; method < 3; ++method) {
            ExtractionParameters parameters;
            parameters.method = static_cast<Method>(method);
            parameters.sigma_wall_m = 0;
            const auto extractor = make_line_extractor(parameters);
            lines_world::Score score;
            LineSegments segments;
            for (const auto& s : all) {
                extractor->extract(s.sweep.scan, segments);
                score.add(s.world, s.sensor.T_world_sensor, s.sweep, segments);
            }
            std::printf("%-34s %-16s %7.1f %7.3f %6.2f %6.2f %6.2f %6.2f %7.1f\n", setup.name,
                        method_names[method], microseconds_per_scan(*extractor, scans), score.recall(),
                        100.0 * score.false_lines / static_cast<double>(all.size()),
                        100.0 * score.repeated / static_cast<double>(all.size()), score.rho_rms(),
                        score.alpha_rms(), 1e3 * median(score.end_errors_m));
        }
    }
}

// ---- Covariance
// ---------------------------------------------------------------------------------------------------

void compare_covariances() {
    std::printf(
        "\nCovariance: claimed / scatter over 20000 scans of one wall (1 is honest), and correlation of rho "
        "and alpha.\n\n"
        "%-30s %10s %10s %9s %9s %9s %9s\n",
        "view", "rho mm", "alpha deg", "var rho", "var alpha", "claimed", "scatter");
    for (const auto& view : lines_world::views) {
        const auto s = lines_world::monte_carlo(view, ExtractionParameters{}.method, 20000);
        std::printf("%-30s %10.2f %10.4f %9.3f %9.3f %9.3f %9.3f\n", view.name,
                    1e3 * std::sqrt(s.scatter(0, 0)), std::sqrt(s.scatter(1, 1)) * 180 / M_PI,
                    s.claimed(0, 0) / s.scatter(0, 0), s.claimed(1, 1) / s.scatter(1, 1),
                    lines_world::correlation(s.claimed), lines_world::correlation(s.scatter));
    }
}

// ---- Real logs
// ----------------------------------------------------------------------------------------------------

std::vector<CObservation2DRangeScan::Ptr> scans_of(const std::string& path) {
    std::vector<CObservation2DRangeScan::Ptr> scans;
    mrpt::io::CFileGZInputStream file;
    if (!std::filesystem::exists(path) || !file.open(path)) return scans;
    auto archive = mrpt::serialization::archiveFrom(file);
    const auto take = [&](const mrpt::serialization::CSerializable::Ptr& object) {
        if (auto scan = std::dynamic_pointer_cast<CObservation2DRangeScan>(object)) scans.push_back(scan);
    };
    try {
        for (;;) {
            const auto object = archive.ReadObject();
            if (const auto frame = std::dynamic_pointer_cast<mrpt::obs::CSensoryFrame>(object))
                for (const auto& observation : *frame) take(observation);
            else
                take(object);
        }
    } catch (const std::exception&) {  // the end of the file
    }
    return scans;
}

CObservation2DRangeScan::Ptr every_second_beam(const CObservation2DRangeScan& scan) {
    std::vector<float> ranges;
    std::vector<char> valid;
    for (std::size_t i = 0; i < scan.getScanSize(); i += 2) {
        ranges.push_back(scan.getScanRange(i));
        valid.push_back(scan.getScanRangeValidity(i));
    }
    auto half = CObservation2DRangeScan::Create(scan);
    half->loadFromVectors(ranges.size(), ranges.data(), valid.data());
    return half;
}

/// The settings of MRPT's icp-slam_demo_classic.ini.
mrpt::slam::CICP::TConfigParams icp_slam_settings() {
    mrpt::slam::CICP::TConfigParams settings;
    settings.maxIterations = 80;
    settings.thresholdDist = 0.3;
    settings.thresholdAng = 5 * M_PI / 180;
    settings.ALFA = 0.8;
    settings.smallestThresholdDist = 0.05;
    return settings;
}

/// The same with every point, as every beam takes part in the lines; MRPT's default is every fifth.
mrpt::slam::CICP::TConfigParams all_points() {
    mrpt::slam::CICP::TConfigParams settings = icp_slam_settings();
    settings.corresponding_points_decimation = 1;
    return settings;
}

/// Mean CPU time of one classic CICP alignment of consecutive scans, starting from no motion.
double microseconds_per_alignment(const std::vector<CObservation2DRangeScan::Ptr>& scans,
                                  const mrpt::slam::CICP::TConfigParams& settings) {
    mrpt::slam::CICP icp(settings);
    double total_us = 0;
    std::size_t alignments = 0;
    for (std::size_t i = 1; i < scans.size() && alignments < 500; ++i, ++alignments) {
        mrpt::maps::CSimplePointsMap reference, current;
        reference.insertObservation(*scans[i - 1]);
        current.insertObservation(*scans[i]);
        mrpt::slam::CICP::TReturnInfo information;
        const double start = cpu_s();
        icp.Align(&reference, &current, mrpt::poses::CPose2D(), information);
        total_us += (cpu_s() - start) * 1e6;
    }
    return total_us / static_cast<double>(alignments);
}

void compare_on_log(const char* name, std::vector<CObservation2DRangeScan::Ptr> observations,
                    std::size_t every) {
    std::vector<CObservation2DRangeScan::Ptr> consecutive = observations;
    std::vector<PlanarScan> scans;
    for (std::size_t i = 0; i < observations.size(); i += every) {
        PlanarScan scan;
        if (to_planar_scan(*observations[i], scan)) scans.push_back(scan);
    }
    if (scans.empty()) {
        std::printf("%-34s (log not here)\n", name);
        return;
    }
    std::vector<const PlanarScan*> pointers;
    for (const auto& s : scans) pointers.push_back(&s);
    const double alignment_us = microseconds_per_alignment(consecutive, {});
    const double icp_slam_us = microseconds_per_alignment(consecutive, icp_slam_settings());
    const double all_points_us = microseconds_per_alignment(consecutive, all_points());
    for (int method = 0; method < 3; ++method) {
        ExtractionParameters parameters;
        parameters.method = static_cast<Method>(method);
        const auto extractor = make_line_extractor(parameters);
        const double us = microseconds_per_scan(*extractor, pointers);
        double lines = 0, on_lines = 0, returns = 0, length_m = 0;
        LineSegments segments;
        for (const auto& scan : scans) {
            extractor->extract(scan, segments);
            lines += static_cast<double>(segments.size());
            returns += static_cast<double>(scan.returns());
            for (const auto& s : segments) {
                on_lines += static_cast<double>(s.beam_count);
                length_m += s.length_m();
            }
        }
        std::printf("%-34s %-16s %7.1f %7zu %6.2f %6.1f %6.2f %8.0f %6.1f %8.0f %6.1f %8.0f %6.1f\n", name,
                    method_names[method], us, scans[0].size(), lines / static_cast<double>(scans.size()),
                    100 * on_lines / returns, length_m / lines, alignment_us, 100 * us / alignment_us,
                    icp_slam_us, 100 * us / icp_slam_us, all_points_us, 100 * us / all_points_us);
    }
}

void compare_on_logs() {
    std::printf(
        "\nLogs. On lines: returns that belong to a line. CICP: one classic alignment of consecutive scans, "
        "mean,\nwith its default options; as MRPT's icp-slam_demo_classic.ini sets them (demo); the same "
        "with "
        "all points\n(all; both others take every fifth point).\n\n"
        "%-34s %-16s %7s %7s %6s %6s %6s %8s %6s %8s %6s %8s %6s\n",
        "log", "method", "us/scan", "beams", "lines", "on %", "len m", "CICP us", "%", "demo us", "%",
        "all us", "%");
    const std::string datasets = "/usr/share/mrpt/datasets/";
    const char* folder = std::getenv("LOOPLINE_DATA");
    const std::string data = folder ? folder : test::source_folder() + "/../shared/data";
    const auto telecom = scans_of(datasets + "2006-01ENE-21-SENA_Telecom Faculty_one_loop_only.rawlog");
    std::vector<CObservation2DRangeScan::Ptr> half;
    for (const auto& scan : telecom) half.push_back(every_second_beam(*scan));
    compare_on_log("Telecom Faculty, every 2nd beam", half, 1);
    compare_on_log("Telecom Faculty", telecom, 1);
    const std::string demos = datasets + "graphslam-engine-demos/action_observations_map/";
    compare_on_log("simul", scans_of(demos + "simul.rawlog"), 5);
    compare_on_log("range_030_bearing_015", scans_of(demos + "range_030_bearing_015.rawlog"), 5);
    compare_on_log("Intel lab", scans_of(data + "/intel/intel_part1_full_rate.sf.rawlog"), 5);
}

}  // namespace

int main() {
    compare_on_worlds();
    compare_covariances();
    compare_on_logs();
}
