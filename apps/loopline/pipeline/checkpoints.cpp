#include "pipeline/checkpoints.h"

#include <algorithm>
#include <ctime>
#include <iterator>

namespace loopline {
namespace {
constexpr double pause_per_writing = 99;  // so that writing takes at most a hundredth
constexpr std::chrono::milliseconds beginning{100};

double cpu_time_s() {
    timespec time{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}
}  // namespace

Checkpoints::Checkpoints(const RunSetup& setup, const Attempt& attempt, ModuleChain& chain,
                         Recorder& recorder)
    : setup_(setup),
      chain_(chain),
      recorder_(recorder),
      possible_(!setup.calibrates && modules_without_state(setup.experiment).empty()),
      every_items_(static_cast<std::uint64_t>(setup.experiment.run.checkpoint_items)) {
    if (setup.checkpoint && attempt.first()) {
        setup.checkpoint->restore(chain, recorder);
        resumed_at_ = setup.checkpoint->head().items;
        logs_ = setup.checkpoint->head().logs;
    }
    if (possible_ && setup.experiment.outputs.states_mb > 0)
        for (const auto& module : chain.modules())
            if (closer_ == nullptr) closer_ = dynamic_cast<const LoopCloser*>(module.get());
    if (resumed_at_ > 0) {
        const auto& kept = setup.checkpoint->head().kept;
        std::copy_if(kept.begin(), kept.end(), std::back_inserter(kept_), [&setup](const KeptState& state) {
            std::error_code none;
            return std::filesystem::exists(setup.folder / kept_state_name(state.loop), none);
        });
        if (closer_ != nullptr) loop_at_hand_ = closer_->loop_at_hand();
    }
    schedule(0);
    if (next_look_ != never && resumed_at_ == 0) next_look_ = Clock::now() + beginning;
    began_ = resumed_at_ > 0;
    // If this is killed, --resume must not go on from before the rejection.
    if (resumed_at_ > 0 && setup.checkpoint->head().loop > 0)
        write(resumed_at_);
    else
        written_at_ = resumed_at_;
}

/// The next one, `least_s` of CPU time from now or later.
void Checkpoints::schedule(double least_s) {
    const double pause_s = setup_.experiment.run.checkpoint_s;
    next_look_ = possible_ && pause_s > 0 ? Clock::now() : never;
    due_s_ = cpu_time_s() + std::max(least_s, pause_s);
}

void Checkpoints::glance_at_the_clock(std::uint64_t items) {
    latest_glance_ = chain_.latest_tick();
    if (Clock::now() >= next_look_) look_at_the_clock(items);
}

void Checkpoints::look_at_the_clock(std::uint64_t items) {
    if (!began_) {
        began_ = true;
        try {
            made_folder_ = std::filesystem::create_directories(setup_.folder);
            write_beginning(checkpoint_in(setup_.folder), head(0));
        } catch (const std::exception& e) {
            give_up(e);
        }
        return;
    }
    const double missing_s = due_s_ - cpu_time_s();
    if (missing_s <= 0)
        write(items);
    else
        next_look_ = Clock::now() +
                     std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(missing_s));
}

CheckpointHead Checkpoints::head(std::uint64_t items) {
    RunRecord cost;
    set_cost(cost, setup_);
    return {build_of_this_program(),
            setup_.experiment.effective_ini,
            logs(),
            items,
            cost.wall_s + earlier_wall_s(),
            cost.cpu_s + earlier_cpu_s(),
            0,
            0,
            kept_};
}

void Checkpoints::give_up(const std::exception& reason) {
    possible_ = false;
    every_items_ = 0;
    next_look_ = never;
    warnings_.push_back(std::string("no checkpoint is kept: ") + reason.what());
}

void Checkpoints::discard() {
    std::error_code ignored;
    remove_checkpoint(setup_.folder);
    if (made_folder_) std::filesystem::remove(setup_.folder, ignored);  // if it is empty
}

bool Checkpoints::write(std::uint64_t items) {
    if (!possible_) return false;
    if (items == written_at_) return true;
    try {
        began_ = true;
        const CheckpointHead now = head(items);  // with the logs' hashes, which are needed at the end anyway
        const auto start = Clock::now();
        made_folder_ = std::filesystem::create_directories(setup_.folder) || made_folder_;
        write_checkpoint(checkpoint_in(setup_.folder), now, chain_, recorder_);
        written_at_ = items;
        schedule(pause_per_writing * std::chrono::duration<double>(Clock::now() - start).count());
        return true;
    } catch (const std::exception& e) {
        give_up(e);
    }
    return false;
}

/// A loop is going to be closed, or one was: then there is nothing to do.
void Checkpoints::keep_state(std::uint64_t items) {
    loop_at_hand_ = closer_->loop_at_hand();
    if (loop_at_hand_ == 0) return;
    try {
        CheckpointHead now = head(items);
        now.loop = loop_at_hand_;
        now.loop_ns = closer_->loop_at_hand_ns();
        const auto file = setup_.folder / kept_state_name(loop_at_hand_);
        made_folder_ = std::filesystem::create_directories(setup_.folder) || made_folder_;
        std::filesystem::create_directories(file.parent_path());
        write_kept_state(file, now, chain_, recorder_);
        kept_.push_back({loop_at_hand_, items, std::filesystem::file_size(file)});
        thin_kept_states(setup_.folder, static_cast<std::uint64_t>(setup_.experiment.outputs.states_mb * 1e6),
                         kept_);
    } catch (const std::exception& e) {
        closer_ = nullptr;
        warnings_.push_back(std::string("no more states are kept before loops: ") + e.what());
    }
}

const std::vector<LogIdentity>& Checkpoints::logs() {
    if (logs_.empty()) logs_ = identities_of(input_paths(setup_.experiment));
    return logs_;
}

}  // namespace loopline
