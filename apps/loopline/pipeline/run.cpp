#include "pipeline/run.h"

#include <sys/resource.h>

#include <algorithm>
#include <cstdio>
#include <iostream>

#include "pipeline/checkpoint.h"
#include "pipeline/estimate_pass.h"
#include "pipeline/large_pages.h"
#include "pipeline/map_pass.h"
#include "pipeline/run_outputs.h"
#include "pipeline/run_scratch.h"

namespace loopline {
namespace {

double seconds(const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

void tell_result(const RunRecord& record, const std::filesystem::path& folder) {
    const double log_s = seconds_between(record.first_stamp_ns, record.last_stamp_ns);
    const double distance_m = record.trajectory != nullptr ? record.trajectory->length_m() : 0;
    std::printf("%llu scans, %.1f m, %.1f s of log in %.2f s (%.0f x real time)\n",
                static_cast<unsigned long long>(record.scans_read), distance_m, log_s, record.wall_s,
                log_s / record.wall_s);
    const auto error = record.results.metrics.find("ate_rmse_m");
    if (error != record.results.metrics.end() && std::holds_alternative<double>(error->second))
        std::printf("error against the truth (ATE, rmse): %.3f m\n", std::get<double>(error->second));
    std::printf("result: %s\n", folder.c_str());
}

}  // namespace

void tell_problems(const RunRecord& record) {
    for (const auto& sentence : record.warnings) std::cerr << "loopline: warning: " << sentence << '\n';
    for (const auto& input : record.inputs)
        if (!input.damage.empty()) std::cerr << "loopline: " << input.damage << '\n';
    if (record.results.refused) std::cerr << "loopline: " << *record.results.refused << '\n';
    if (record.status == "interrupted")
        std::cerr << "loopline: interrupted; what was read until then is processed and saved"
                  << (record.can_resume ? ", and --resume goes on from there" : "") << "\n";
}

void set_cost(RunRecord& record, const RunSetup& setup) {
    rusage used{};
    getrusage(RUSAGE_SELF, &used);
    record.cpu_s =
        record.earlier_cpu_s + setup.cpu_before_s + seconds(used.ru_utime) + seconds(used.ru_stime);
    record.peak_memory_mb = std::max(setup.peak_before_mb, static_cast<double>(used.ru_maxrss) / 1024);
    const std::chrono::duration<double> here = std::chrono::steady_clock::now() - setup.start;
    record.wall_s = record.earlier_wall_s + here.count();
}

int run_experiment(const RunSetup& setup, const Attempt& attempt) {
    RunRecord record;
    const std::uint64_t items = estimate_pass(setup, attempt, record);
    if (record.can_resume && setup.scratch != nullptr) setup.scratch->keep();
    map_pass(setup, attempt, items, record);
    write_results(setup, record, attempt.rules.state);
    tell_problems(record);
    give_back_free_memory();
    draw_results(setup, record, attempt.rules.state);
    if (record.status != "interrupted") remove_checkpoint(setup.folder);
    if (!setup.quiet) tell_result(record, setup.folder);
    std::fflush(stdout);
    return record.exit_code;
}

}  // namespace loopline
