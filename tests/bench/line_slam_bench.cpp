/// How much of line SLAM's accuracy is luck? Each log 20 times: once as it is, then with 3 mm of range noise
/// and 1 % of odometry noise added, beginning a few scans later. And what a scan costs. Prints a table; takes
/// no arguments.
#include <mrpt/io/CFileGZInputStream.h>
#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CActionRobotMovement2D.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/poses/CPose2D.h>
#include <mrpt/serialization/CArchive.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include "api/planar_scan.h"
#include "api/stamp.h"
#include "line_slam/line_ekf_slam.h"
#include "line_slam/line_input.h"
#include "line_slam/smoother.h"
#include "lines/line_extractor.h"

using namespace loopline;
using namespace loopline::line_slam;

namespace {

constexpr int runs = 20;
constexpr double sigma_range_m = 0.003, sigma_odometry = 0.01;
const std::string datasets = "/usr/share/mrpt/datasets/";

double cpu_s() {
    timespec t{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

struct Step {
    double t_s = 0;
    Pose2 T_previous_base;  ///< by the wheels
    PlanarScan scan;
};

/// Scans of a log of actions and frames.
std::vector<Step> steps_of(const std::string& file) {
    mrpt::io::CFileGZInputStream stream;
    std::vector<Step> steps;
    if (!stream.open(file)) return steps;
    auto archive = mrpt::serialization::archiveFrom(stream);
    Pose2 T_previous_base;
    try {
        for (;;) {
            const auto object = archive.ReadObject();
            if (const auto actions = std::dynamic_pointer_cast<mrpt::obs::CActionCollection>(object)) {
                const auto movement = actions->getBestMovementEstimation();
                if (!movement) continue;
                const mrpt::poses::CPose2D mean = movement->poseChange->getMeanVal();
                T_previous_base = T_previous_base * Pose2{mean.x(), mean.y(), mean.phi()};
            }
            const auto frame = std::dynamic_pointer_cast<mrpt::obs::CSensoryFrame>(object);
            const auto scan =
                frame ? frame->getObservationByClass<mrpt::obs::CObservation2DRangeScan>() : nullptr;
            Step step;
            if (!scan || !to_planar_scan(*scan, step.scan)) continue;
            step.t_s = 1e-9 * static_cast<double>(stamp_from_mrpt(scan->timestamp).value_or(0));
            step.T_previous_base = steps.empty() ? Pose2{} : T_previous_base;
            T_previous_base = Pose2{};
            steps.push_back(std::move(step));
        }
    } catch (const std::exception&) {  // the end of the file
    }
    return steps;
}

void disturb(Step& step, std::mt19937_64& random) {
    std::normal_distribution<double> normal;
    for (float& range_m : step.scan.ranges_m)
        if (range_m > 0.01f && range_m < step.scan.max_range_m)
            range_m += static_cast<float>(sigma_range_m * normal(random));
    Pose2& T = step.T_previous_base;
    for (double* value : {&T.x_m, &T.y_m, &T.phi_rad}) *value *= 1 + sigma_odometry * normal(random);
}

struct Path {
    std::vector<double> t_s;
    std::vector<Pose2> online, smoothed;
    double scan_us = 0, smoothing_ms = 0;
};

Path drive(const std::vector<Step>& log, int run) {
    std::mt19937_64 random(static_cast<std::uint64_t>(run));
    const LineSlamParameters parameters;
    LineEkfSlam slam(parameters);
    const auto extractor = lines::make_line_extractor({});
    lines::LineSegments segments;
    Path path;
    double in_filter_s = 0;
    for (std::size_t k = static_cast<std::size_t>(3 * run % 7); k < log.size(); ++k) {
        Step step = log[k];
        if (run > 0) disturb(step, random);
        if (path.t_s.empty()) step.T_previous_base = Pose2{};
        extractor->extract(step.scan, segments);
        std::vector<LineObservation> observations;
        for (const auto& s : segments)
            observations.push_back(observation_in_base(s, step.scan.T_base_sensor, parameters.sigma_wall_m));
        const double start_s = cpu_s();
        if (slam.step(step.T_previous_base, std::move(observations)) != SlamStatus::good) break;
        in_filter_s += cpu_s() - start_s;
        path.t_s.push_back(step.t_s);
        path.online.push_back(slam.filter().T_map_base());
    }
    const double start_s = cpu_s();
    path.smoothed = smooth(slam.history(), {}).poses;
    path.smoothing_ms = 1e3 * (cpu_s() - start_s);
    path.scan_us = 1e6 * in_filter_s / static_cast<double>(path.t_s.size());
    return path;
}

struct TruePose {
    double t_s;
    Eigen::Vector2d p_m;
};

std::vector<TruePose> read_truth(const std::string& file) {
    std::ifstream in(file);
    std::vector<TruePose> truth;
    double phi = 0;
    for (TruePose p{}; in >> p.t_s >> p.p_m.x() >> p.p_m.y() >> phi;) truth.push_back(p);
    return truth;
}

/// Root mean square distance from the nearest true poses in time, after the best rigid motion.
double ate_m(const Path& path, const std::vector<Pose2>& poses, const std::vector<TruePose>& truth) {
    const auto n = static_cast<Eigen::Index>(poses.size());
    Eigen::MatrixXd A(2, n), B(2, n);
    for (Eigen::Index i = 0; i < n; ++i) {
        const double t_s = path.t_s[static_cast<std::size_t>(i)];
        A.col(i) = poses[static_cast<std::size_t>(i)].translation();
        B.col(i) = std::min_element(truth.begin(), truth.end(), [&](const auto& a, const auto& b) {
                       return std::abs(a.t_s - t_s) < std::abs(b.t_s - t_s);
                   })->p_m;
    }
    const Eigen::MatrixXd T = Eigen::umeyama(A, B, false);
    const Eigen::MatrixXd moved = (T.topLeftCorner(2, 2) * A).colwise() + T.col(2).head(2);
    return std::sqrt((moved - B).colwise().squaredNorm().mean());
}

/// Distance of the last pose from where MRPT's rbpf-slam and icp-slam agree it to be.
double telecom_end_m(const std::vector<Pose2>& poses) {
    return (poses.back().translation() - Eigen::Vector2d(4.27, -18.47)).norm();
}

double quantile(std::vector<double> values, double share) {
    std::sort(values.begin(), values.end());
    return values[std::min(values.size() - 1,
                           static_cast<std::size_t>(share * static_cast<double>(values.size())))];
}

void report(const char* name, const std::string& file, const std::string& truth_file) {
    const std::vector<Step> log = steps_of(file);
    if (log.empty()) {
        std::printf("%-24s (log not here)\n", name);
        return;
    }
    const std::vector<TruePose> truth = truth_file.empty() ? std::vector<TruePose>{} : read_truth(truth_file);
    std::vector<double> online, smoothed, scan_us, smoothing_ms;
    for (int run = 0; run < runs; ++run) {
        const Path path = drive(log, run);
        const auto error_m = [&](const std::vector<Pose2>& poses) {
            return truth.empty() ? telecom_end_m(poses) : ate_m(path, poses, truth);
        };
        online.push_back(error_m(path.online));
        smoothed.push_back(error_m(path.smoothed));
        scan_us.push_back(path.scan_us);
        smoothing_ms.push_back(path.smoothing_ms);
    }
    std::printf("%-24s %6zu %8.3f %8.3f %8.3f %8.3f %8.3f %8.3f %10.1f %10.1f\n", name, log.size(), online[0],
                quantile(online, 0.5), quantile(online, 1), smoothed[0], quantile(smoothed, 0.5),
                quantile(smoothed, 1), quantile(scan_us, 0.5), quantile(smoothing_ms, 0.5));
}

}  // namespace

int main() {
    std::printf(
        "Error in m of the online and of the smoothed path: log as it is, then median and worst of %d runs "
        "with\n%.0f mm of range noise and %.0f %% of odometry noise added. Telecom: of the end pose; others: "
        "ATE.\n\n%-24s %6s %8s %8s %8s %8s %8s %8s %10s %10s\n",
        runs, 1e3 * sigma_range_m, 1e2 * sigma_odometry, "log", "scans", "online", "median", "worst",
        "smoothed", "median", "worst", "us/scan", "smooth ms");
    report("Telecom Faculty", datasets + "2006-01ENE-21-SENA_Telecom Faculty_one_loop_only.rawlog", "");
    for (const char* name : {"simul", "range_030_bearing_015"}) {
        const std::string file =
            datasets + "graphslam-engine-demos/action_observations_map/" + name + ".rawlog";
        report(name, file, file + ".GT.txt");
    }
}
