/// Starts at speed: lidar_odometry and lidar_mapping begin at every Nth sweep of a log, as if nothing had
/// come before, and take four more. How many have a wrong velocity then, and what does the second sweep cost,
/// which has the search for it? One thread, CPU time. Arguments: a log, the TUM file of its truth, N.
#include <mrpt/io/CFileGZInputStream.h>
#include <mrpt/obs/CObservation.h>
#include <mrpt/serialization/CArchive.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <deque>

#include "evaluate/read_trajectory.h"
#include "lidar/observation_scan.h"
#include "lidar_mapping/sweep_mapping.h"
#include "lidar_odometry/sweep_odometry.h"

using namespace loopline;

namespace {

constexpr std::size_t sweeps_of_a_start = 5;
constexpr double wrong_mps = 0.5;

double cpu_ms() {
    timespec t{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return 1e3 * static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_nsec);
}

struct Outcome {
    int starts = 0, wrong = 0;
    double worst_mps = 0, second_ms = 0, worst_second_ms = 0;

    void add(double error_mps, double ms) {
        ++starts;
        wrong += error_mps > wrong_mps ? 1 : 0;
        worst_mps = std::max(worst_mps, error_mps);
        second_ms += ms;
        worst_second_ms = std::max(worst_second_ms, ms);
    }
    void print(const char* name) const {
        std::printf(
            "%-15s %5d starts, %3d wrong by more than %.1f m/s (worst %.2f), second sweep %.1f ms, worst "
            "%.1f\n",
            name, starts, wrong, wrong_mps, worst_mps, second_ms / std::max(1, starts), worst_second_ms);
    }
};

/// `velocity(k)` after sweep k was added.
template <class Add>
void start(const std::deque<lidar::SpinningScan>& sweeps, double truth_mps, Outcome& outcome,
           const Add& add) {
    double second_ms = 0;
    Eigen::Vector3d v_base_mps = Eigen::Vector3d::Zero();
    for (std::size_t k = 0; k < sweeps.size(); ++k) {
        const double begin_ms = cpu_ms();
        v_base_mps = add(sweeps[k]);
        if (k == 1) second_ms = cpu_ms() - begin_ms;
    }
    outcome.add(std::abs(v_base_mps.x() - truth_mps), second_ms);
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 4) {
        std::fputs("lidar_starts LOG TRUTH.tum EVERY_NTH_SWEEP\n", stderr);
        return 2;
    }
    const auto truth = read_trajectory(argv[2], "the truth").poses;
    const auto every = static_cast<std::size_t>(std::max(1, std::atoi(argv[3])));
    lidar::SpinningScanReader reader{lidar::SweepConvention()};
    mrpt::io::CFileGZInputStream file(argv[1]);
    auto archive = mrpt::serialization::archiveFrom(file);
    std::deque<lidar::SpinningScan> sweeps;
    lidar::SpinningScan scan;
    Outcome odometry, mapping;
    std::size_t count = 0;
    try {
        for (;;) {
            const auto observation = std::dynamic_pointer_cast<mrpt::obs::CObservation>(archive.ReadObject());
            if (!observation || !reader.read(*observation, scan)) continue;
            sweeps.push_back(scan);
            if (sweeps.size() > sweeps_of_a_start) sweeps.pop_front();
            if (++count < sweeps_of_a_start || count % every != 0) continue;
            const StampNs begin_ns = sweeps[3].stamp_ns, end_ns = sweeps[4].stamp_ns;
            const auto pose_at = [&](StampNs t) {
                return std::lower_bound(truth.begin(), truth.end(), t,
                                        [](const auto& p, StampNs s) { return p.stamp_ns < s; });
            };
            const auto a = pose_at(begin_ns), b = pose_at(end_ns);
            if (b == truth.end() || a == b) continue;
            const double truth_mps = (a->T_map_base.inverse() * b->T_map_base).translation_m.x() /
                                     seconds_between(a->stamp_ns, b->stamp_ns);
            lidar_odometry::SweepOdometry one({}, 1);
            start(sweeps, truth_mps, odometry, [&](const auto& sweep) {
                one.add(sweep);
                return one.latest().velocity.shift_m;
            });
            lidar_mapping::SweepMapping two({}, 1);
            start(sweeps, truth_mps, mapping,
                  [&](const auto& sweep) { return two.add(sweep).state.velocity.shift_m; });
        }
    } catch (const std::exception&) {
        // the log's end
    }
    odometry.print("lidar_odometry");
    mapping.print("lidar_mapping");
}
