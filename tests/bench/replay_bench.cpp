/// What the host's reading costs: the same log by a bare loop over CArchive::ReadObject() on MRPT's own
/// stream, and by the host's source and an empty chain, in one program. Prints the ratio of their rates.
///   build/release/bin/replay_bench [LOG]...
#include <mrpt/io/CFileGZInputStream.h>
#include <mrpt/serialization/CArchive.h>
#include <sys/resource.h>

#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "pipeline/log_source.h"
#include "pipeline/module_chain.h"

using namespace loopline;

namespace {

constexpr int rounds = 15;

double cpu_s() {
    rusage used{};
    getrusage(RUSAGE_SELF, &used);
    return static_cast<double>(used.ru_utime.tv_sec + used.ru_stime.tv_sec) +
           1e-6 * static_cast<double>(used.ru_utime.tv_usec + used.ru_stime.tv_usec);
}

std::size_t bare_loop(const std::string& log) {
    mrpt::io::CFileGZInputStream file(log);
    auto archive = mrpt::serialization::archiveFrom(file);
    std::size_t objects = 0;
    try {
        for (;; ++objects) archive.ReadObject();
    } catch (const mrpt::serialization::CExceptionEOF&) {
    }
    return objects;
}

std::size_t host_loop(const std::string& log, WorkerState& state) {
    LogSource source({log}, ReadingRules{&state, {}});
    ModuleChain chain({}, &state);
    for (StreamItem item; source.next(item);) chain.process(item);
    return source.reader(0).objects();
}

double median(std::vector<double> values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

void compare(const std::string& log) {
    WorkerState state;
    std::vector<double> bare_s, host_s;
    const std::size_t objects = bare_loop(log);
    for (int i = 0; i < rounds; ++i) {
        const double start_s = cpu_s();
        const std::size_t bare_objects = bare_loop(log);
        const double between_s = cpu_s();
        const std::size_t host_objects = host_loop(log, state);
        bare_s.push_back(between_s - start_s);
        host_s.push_back(cpu_s() - between_s);
        if (bare_objects != objects || host_objects != objects)
            std::printf("the loops differ on %s\n", log.c_str());
    }
    std::printf(
        "%s: %zu objects; bare loop %.1f ms, host %.1f ms CPU (medians of %d); host / bare rate %.2f\n",
        log.c_str(), objects, 1e3 * median(bare_s), 1e3 * median(host_s), rounds,
        median(bare_s) / median(host_s));
}

}  // namespace

int main(int argc, char** argv) {
    std::vector<std::string> logs(argv + 1, argv + argc);
    if (logs.empty())
        logs = {"/usr/share/mrpt/datasets/2006-01ENE-21-SENA_Telecom Faculty_one_loop_only.rawlog",
                "/usr/share/mrpt/datasets/graphslam-engine-demos/action_observations_map/simul.rawlog"};
    for (const auto& log : logs) compare(log);
}
