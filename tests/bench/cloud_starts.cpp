/// Starts in a finished cloud: localisation begins at every Nth sweep of a log, as if nothing had come
/// before, with fixes that err by SIGMA_M, and has two seconds. How many have found the place, how many a
/// wrong one, how wrong is the first pose, and what does a look cost? One thread, CPU time. Arguments: a log,
/// the TUM file of its path in the frame of the map, the run directory of the map, N, SIGMA_M.
#include <mrpt/io/CFileGZInputStream.h>
#include <mrpt/obs/CObservation.h>
#include <mrpt/serialization/CArchive.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <deque>
#include <random>

#include "cloud_localisation/cloud_localisation.h"
#include "cloud_localisation/map_file.h"
#include "evaluate/read_trajectory.h"
#include "lidar/observation_scan.h"

using namespace loopline;
using namespace loopline::cloud_localisation;

namespace {

constexpr std::size_t sweeps_of_a_start = 20;
constexpr double wrong_m = 0.3, wrong_deg = 2;

double cpu_ms() {
    timespec t{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return 1e3 * static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_nsec);
}

struct Outcome {
    int starts = 0, found = 0, wrong = 0;
    double squares_m2 = 0, squares_deg2 = 0, worst_m = 0, worst_deg = 0, after_s = 0, latest_s = 0;
    double look_ms = 0, worst_look_ms = 0;
    double least_fit = 1, most_rival = 0;
    std::int64_t looks = 0;

    void add(double error_m, double error_deg, double after, const StartLook& look) {
        ++found;
        least_fit = std::min(least_fit, look.fit);
        most_rival = std::max(most_rival, look.rival_fit / look.fit);
        if (error_m > wrong_m || error_deg > wrong_deg) {
            ++wrong;
            return;
        }
        squares_m2 += error_m * error_m;
        squares_deg2 += error_deg * error_deg;
        worst_m = std::max(worst_m, error_m);
        worst_deg = std::max(worst_deg, error_deg);
        after_s += after;
        latest_s = std::max(latest_s, after);
    }
    void print() const {
        const double right = std::max(1, found - wrong);
        std::printf(
            "%d starts, %d found, %d of them wrong; first pose %.3f m rms, %.3f worst, heading %.3f deg rms, "
            "%.3f worst; after %.2f s, %.2f at the latest; a look %.0f ms, %.0f "
            "worst; fits by %.2f at the least, another place by %.2f of that at the most\n",
            starts, found, wrong, std::sqrt(squares_m2 / right), worst_m, std::sqrt(squares_deg2 / right),
            worst_deg, after_s / right, latest_s,
            look_ms / static_cast<double>(std::max<std::int64_t>(1, looks)), worst_look_ms, least_fit,
            most_rival);
    }
};

/// The pose of the sweep's stamp; null if there is none.
const Pose3* pose_of_sweep(const std::deque<StampedPose>& poses, StampNs stamp_ns) {
    for (const StampedPose& pose : poses)
        if (std::abs(pose.stamp_ns - stamp_ns) < 1'000'000) return &pose.T_map_base;
    return nullptr;
}

struct Sweep {
    lidar::SpinningScan scan;
    Pose3 T_map_base;
};

void start(const std::deque<Sweep>& sweeps, const FrozenCloud& map, double sigma_m, std::mt19937_64& random,
           Outcome& outcome) {
    std::normal_distribution<double> normal(0, sigma_m);
    const double x_m = normal(random), y_m = normal(random), z_m = 2 * normal(random);
    CloudLocalisation localisation({}, map, 1);
    ++outcome.starts;
    for (std::size_t k = 0; k < sweeps.size(); ++k) {
        FixInMap fix;
        fix.stamp_ns = sweeps[k].scan.stamp_ns;
        fix.p_base_antenna_m = {-0.5, 0, 1.6};
        fix.p_map_m = sweeps[k].T_map_base * fix.p_base_antenna_m + Eigen::Vector3d(x_m, y_m, z_m);
        fix.sigma_m = sigma_m;
        fix.has_height = true;
        fix.sigma_z_m = 2 * sigma_m;
        localisation.take_fix(fix);
        const std::int64_t looks = localisation.counts().looks;
        const double begin_ms = cpu_ms();
        const LocalisedSweep found = localisation.add(sweeps[k].scan);
        const double ms = cpu_ms() - begin_ms;
        if (localisation.counts().looks > looks) {
            ++outcome.looks;
            outcome.look_ms += ms;
            outcome.worst_look_ms = std::max(outcome.worst_look_ms, ms);
        }
        if (!found.known) continue;
        const Pose3 off = found.T_map_base.inverse() * sweeps[k].T_map_base;
        outcome.add(off.translation_m.norm(), std::abs(off.yaw_rad()) * 180 / M_PI,
                    seconds_between(sweeps[0].scan.stamp_ns, sweeps[k].scan.stamp_ns),
                    localisation.latest_look());
        return;
    }
    std::printf("not found from %.1f: %s, %.2f against %.2f\n",
                static_cast<double>(sweeps[0].scan.stamp_ns) * 1e-9,
                localisation.latest_look().reason.c_str(), localisation.latest_look().fit,
                localisation.latest_look().rival_fit);
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 6) {
        std::fputs("cloud_starts LOG PATH.tum MAP EVERY_NTH_SWEEP SIGMA_M\n", stderr);
        return 2;
    }
    const auto read = read_trajectory(argv[2], "the path").poses;
    const std::deque<StampedPose> path(read.begin(), read.end());
    const auto every = static_cast<std::size_t>(std::max(1, std::atoi(argv[4])));
    CloudMapFile file_of_map;
    std::string problem;
    if (!open_cloud_map(argv[3], file_of_map, problem)) {
        std::fputs((problem + "\n").c_str(), stderr);
        return 3;
    }
    WorkerPool workers(1);
    const FrozenCloud map(*file_of_map.points, {}, workers);
    lidar::SpinningScanReader reader{lidar::SweepConvention()};
    mrpt::io::CFileGZInputStream file(argv[1]);
    auto archive = mrpt::serialization::archiveFrom(file);
    std::deque<Sweep> sweeps;
    std::mt19937_64 random(1);
    Outcome outcome;
    Sweep next;
    std::size_t count = 0;
    try {
        for (;;) {
            const auto observation = std::dynamic_pointer_cast<mrpt::obs::CObservation>(archive.ReadObject());
            if (!observation || !reader.read(*observation, next.scan)) continue;
            const Pose3* pose = pose_of_sweep(path, next.scan.stamp_ns);
            if (pose == nullptr) continue;
            next.T_map_base = *pose;
            sweeps.push_back(next);
            if (sweeps.size() > sweeps_of_a_start) sweeps.pop_front();
            if (sweeps.size() == sweeps_of_a_start && count++ % every == 0)
                start(sweeps, map, std::atof(argv[5]), random, outcome);
        }
    } catch (const std::exception&) {  // the end of the log
    }
    outcome.print();
    return outcome.wrong == 0 ? 0 : 1;
}
