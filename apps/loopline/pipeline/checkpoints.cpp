#include "pipeline/checkpoints.h"

#include <algorithm>

namespace loopline {
namespace {
/// Writing may take a hundredth of the time.
constexpr int pause_per_writing = 99;
}  // namespace

Checkpoints::Checkpoints(const RunSetup& setup, const Attempt& attempt, ModuleChain& chain,
                         Recorder& recorder)
    : setup_(setup),
      chain_(chain),
      recorder_(recorder),
      possible_(modules_without_state(setup.experiment).empty()),
      every_items_(static_cast<std::uint64_t>(setup.experiment.run.checkpoint_items)) {
    if (setup.checkpoint && attempt.first()) {
        setup.checkpoint->restore(chain, recorder);
        resumed_at_ = setup.checkpoint->head().items;
        logs_ = setup.checkpoint->head().logs;
    }
    schedule({});
}

void Checkpoints::schedule(Clock::duration least) {
    const std::chrono::duration<double> wanted(setup_.experiment.run.checkpoint_s);
    next_ = never;
    if (possible_ && wanted.count() > 0)
        next_ = Clock::now() + std::max(least, std::chrono::duration_cast<Clock::duration>(wanted));
}

bool Checkpoints::write(std::uint64_t items) {
    if (!possible_) return false;
    if (items == resumed_at_) return true;
    const auto file = checkpoint_in(setup_.folder);
    try {
        const auto& identities = logs();  // needed at the end anyway: no part of what writing takes
        const auto start = Clock::now();
        RunRecord cost;
        set_cost(cost, setup_);
        const CheckpointHead head{
            build_of_this_program(),        setup_.experiment.effective_ini, identities, items,
            cost.wall_s + earlier_wall_s(), cost.cpu_s + earlier_cpu_s()};
        write_checkpoint(file, head, chain_, recorder_);
        schedule(pause_per_writing * (Clock::now() - start));
        return true;
    } catch (const std::exception& e) {
        possible_ = false;
        every_items_ = 0;
        next_ = never;
        warnings_.push_back(std::string("no checkpoint is kept: ") + e.what());
    }
    return false;
}

const std::vector<LogIdentity>& Checkpoints::logs() {
    if (logs_.empty()) logs_ = identities_of(setup_.experiment.run.rawlogs);
    return logs_;
}

}  // namespace loopline
