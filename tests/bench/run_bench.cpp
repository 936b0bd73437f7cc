/// What a whole `loopline run` costs beside reading its log: user and system time of the process on the log
/// of the ring corridor with N = 20 and no output but the trajectory, against a process that does nothing but
/// read the same log with MRPT, in turns. And what the modules take at N = 1 and at N = 20. Prints both
/// ratios.
///   build/release/bin/run_bench [LOG]        without LOG, it is simulated first
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "support/built_files.h"

namespace {

namespace fs = std::filesystem;
using Words = std::vector<std::string>;

constexpr int rounds = 11, module_rounds = 5;
const std::string source_folder = loopline::test::source_folder();

struct Cost {
    double cpu_s = 0;  ///< user and system, of the process and all that it waited for
    double peak_mb = 0;
};

/// Ends the program if the process fails.
Cost cost_of(const Words& command) {
    std::vector<char*> words;
    for (const auto& word : command) words.push_back(const_cast<char*>(word.c_str()));
    words.push_back(nullptr);
    std::fflush(stdout);  // or the child would print it again
    const pid_t child = ::fork();
    if (child == 0) {
        if (std::freopen("/dev/null", "w", stdout) != nullptr) ::execv(words[0], words.data());
        ::_exit(127);
    }
    int status = 0;
    rusage used{};
    ::wait4(child, &status, 0, &used);
    if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) {
        std::fprintf(stderr, "%s failed\n", command[0].c_str());
        std::exit(1);
    }
    const auto seconds = [](const timeval& t) { return double(t.tv_sec) + 1e-6 * double(t.tv_usec); };
    return {seconds(used.ru_utime) + seconds(used.ru_stime), double(used.ru_maxrss) / 1024};
}

Words run_command(const std::string& log, const fs::path& out, int interval_scans) {
    Words words = {LOOPLINE_PROGRAM, "run",    source_folder + "/ini/sim/ring_corridor.ini",
                   "--rawlog",       log,      "--out",
                   out.string(),     "--quiet"};
    for (const char* const key : {"outputs.maps=false", "outputs.snapshots=false", "outputs.report=false"}) {
        words.push_back("--set");
        words.push_back(key);
    }
    words.push_back("--set");
    words.push_back("line_slam.interval_scans=" + std::to_string(interval_scans));
    return words;
}

/// In all modules while the log goes by.
double module_seconds(const fs::path& out) {
    const auto metrics = nlohmann::json::parse(std::ifstream(out / "metrics.json"));
    double total_ms = 0;
    for (const auto& module : metrics["modules"])
        total_ms += module["calls"].get<double>() * module["mean_ms"].get<double>();
    return 1e-3 * total_ms;
}

double median(std::vector<double> values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

void compare_processes(const std::string& log, const fs::path& out) {
    std::vector<double> bare_s, run_s, ratios;
    double bare_mb = 0, run_mb = 0;
    for (int i = 0; i < rounds; ++i) {
        const Cost bare = cost_of({LOOPLINE_BARE_LOOP, log}), run = cost_of(run_command(log, out, 20));
        bare_s.push_back(bare.cpu_s);
        run_s.push_back(run.cpu_s);
        ratios.push_back(run.cpu_s / bare.cpu_s);
        bare_mb = std::max(bare_mb, bare.peak_mb);
        run_mb = std::max(run_mb, run.peak_mb);
    }
    std::printf(
        "whole processes, medians of %d: bare loop %.0f ms CPU and %.0f MB, loopline run %.0f ms and %.0f "
        "MB; "
        "run / bare %.2f (worst %.2f)\n",
        rounds, 1e3 * median(bare_s), bare_mb, 1e3 * median(run_s), run_mb, median(ratios),
        *std::max_element(ratios.begin(), ratios.end()));
}

void compare_intervals(const std::string& log, const fs::path& out) {
    std::vector<double> every_s, twentieth_s, ratios;
    for (int i = 0; i < module_rounds; ++i) {
        cost_of(run_command(log, out, 1));
        every_s.push_back(module_seconds(out));
        cost_of(run_command(log, out, 20));
        twentieth_s.push_back(module_seconds(out));
        ratios.push_back(every_s.back() / twentieth_s.back());
    }
    std::printf("in the modules, medians of %d: N = 1 %.0f ms, N = 20 %.0f ms; ratio %.1f\n", module_rounds,
                1e3 * median(every_s), 1e3 * median(twentieth_s), median(ratios));
}

}  // namespace

int main(int argc, char** argv) {
    std::string pattern = (fs::temp_directory_path() / "loopline_run_bench_XXXXXX").string();
    if (::mkdtemp(pattern.data()) == nullptr) return 1;
    const fs::path folder = pattern;
    const std::string log = argc > 1 ? argv[1] : (folder / "ring_corridor.rawlog").string();
    if (argc < 2)
        cost_of({LOOPLINE_PROGRAM, "simulate", source_folder + "/datasets/ring_corridor.ini", "--out", log});
    compare_processes(log, folder / "run");
    compare_intervals(log, folder / "run");
    fs::remove_all(folder);
}
