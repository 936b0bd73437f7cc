/// When a run writes checkpoints. The clock may decide, since no result depends on it: it is the CPU time
/// that a checkpoint saves, and of which it may take a hundredth. Soon after the beginning a first one says
/// no more than that there is nothing to load yet.
#pragma once

#include <chrono>
#include <cstdint>
#include <vector>

#include "api/loop_closer.h"
#include "pipeline/checkpoint.h"
#include "pipeline/kept_states.h"
#include "pipeline/run.h"

namespace loopline {

class Checkpoints {
 public:
    /// Takes up the run at `setup.checkpoint` if there is one and this is the first attempt: one that follows
    /// a crash may read less of the log, and starts over.
    Checkpoints(const RunSetup& setup, const Attempt& attempt, ModuleChain& chain, Recorder& recorder);

    /// Items of the log that the modules know already.
    std::uint64_t resumed_at() const { return resumed_at_; }
    /// Time and CPU time that the run had taken until then.
    double earlier_wall_s() const { return resumed_at_ > 0 ? setup_.checkpoint->head().wall_s : 0; }
    double earlier_cpu_s() const { return resumed_at_ > 0 ? setup_.checkpoint->head().cpu_s : 0; }

    /// After each item that the chain has seen; `items` with it.
    void after_item(std::uint64_t items) {
        if (closer_ != nullptr && closer_->loop_at_hand() != loop_at_hand_) keep_state(items);
        if (every_items_ > 0 && items % every_items_ == 0)
            write(items);
        else if (next_look_ != never && chain_.latest_tick() - latest_glance_ >= ticks_per_glance)
            glance_at_the_clock(items);
    }
    /// Now, if the modules can do it; true if there is one of this moment then. If the disk refuses, a
    /// warning says so, and there are no more.
    bool write(std::uint64_t items);

    /// The run turned out to have nothing to save: takes back what was written.
    void discard();

    /// Of the logs, as they were when the first of these was needed; read once.
    const std::vector<LogIdentity>& logs();

    const std::vector<std::string>& warnings() const { return warnings_; }

    /// Of the moments before loops were closed.
    const std::vector<KeptState>& kept_states() const { return kept_; }

 private:
    using Clock = std::chrono::steady_clock;
    static constexpr Clock::time_point never = Clock::time_point::max();
    /// Of a TickClock: about half a millisecond.
    static constexpr std::int64_t ticks_per_glance = 1'000'000;
    void glance_at_the_clock(std::uint64_t items);
    void look_at_the_clock(std::uint64_t items);
    void keep_state(std::uint64_t items);
    void schedule(double least_s);
    void give_up(const std::exception& reason);
    CheckpointHead head(std::uint64_t items);

    const RunSetup& setup_;
    ModuleChain& chain_;
    Recorder& recorder_;
    bool possible_;
    std::uint64_t every_items_ = 0, resumed_at_ = 0, written_at_ = 0;
    Clock::time_point next_look_ = never;
    std::int64_t latest_glance_ = 0;
    double due_s_ = 0;  ///< CPU time of this process
    bool began_ = false, made_folder_ = false;
    const LoopCloser* closer_ = nullptr;  ///< if states are kept
    std::uint64_t loop_at_hand_ = 0;
    std::vector<KeptState> kept_;
    std::vector<LogIdentity> logs_;
    std::vector<std::string> warnings_;
};

}  // namespace loopline
