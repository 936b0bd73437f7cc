#include "pipeline/module_chain.h"

#include <algorithm>

#include "pipeline/stopwatch.h"

namespace loopline {

/// Appends what is published to the items of the next module.
class ModuleChain::Collector : public Publisher {
 public:
    Collector(std::vector<StreamItem>& items, const Listener& listener, const StreamItem& cause)
        : items_(items),
          listener_(listener),
          cause_sequence_(cause.sequence),
          cause_stamp_ns_(cause.stamp_ns) {}

    void publish(const mrpt::obs::CObservation::Ptr& observation) override {
        publish(observation, cause_sequence_);
    }
    void publish(const mrpt::obs::CObservation::Ptr& observation, std::uint64_t sequence) override {
        const StampNs stamp_ns = stamp_from_mrpt(observation->timestamp).value_or(cause_stamp_ns_);
        items_.push_back({sequence, stamp_ns, observation, true});
        if (listener_) listener_(items_.back());
    }

 private:
    std::vector<StreamItem>& items_;
    const Listener& listener_;
    std::uint64_t cause_sequence_;
    StampNs cause_stamp_ns_;
};

ModuleChain::ModuleChain(const std::vector<Module::Ptr>& modules, WorkerState* state, Listener listener)
    : modules_(modules), timings_(modules.size()), state_(state), listener_(std::move(listener)) {
    for (const auto& module : modules_) interests_.emplace_back(module->info());
}

void ModuleChain::start(const RunContext& context) {
    for (const auto& module : modules_) module->start(context);
}

void ModuleChain::process(const StreamItem& item) {
    items_.assign(1, item);
    flow(0, item.sequence);
}

void ModuleChain::flow(std::size_t first, std::uint64_t root_sequence) {
    auto before = Clock::now();  // the end of one call is the beginning of the next: clocks cost, too
    for (std::size_t i = first; i < modules_.size(); ++i) {
        if (state_ != nullptr) state_->enter(WorkerState::Stage::module, static_cast<int>(i), root_sequence);
        auto& timing = timings_[i];
        next_items_.clear();
        for (const auto& item : items_) {
            next_items_.push_back(item);
            const Interest::Kind interest = interests_[i].in(*item.observation);
            if (interest == Interest::Kind::none) continue;
            Collector publisher(next_items_, listener_, item);
            modules_[i]->process(item, publisher);
            const auto after = Clock::now();
            const double elapsed_ms = milliseconds_between(before, after);
            before = after;
            timing.calls += interest == Interest::Kind::main ? 1 : 0;
            timing.total_ms += elapsed_ms;
            timing.worst_ms = std::max(timing.worst_ms, elapsed_ms);
        }
        items_.swap(next_items_);
    }
    if (state_ != nullptr) state_->stage.store(WorkerState::Stage::idle, std::memory_order_relaxed);
}

void ModuleChain::finish(Results& results) {
    StreamItem last;
    for (std::size_t i = 0; i < modules_.size(); ++i) {
        if (state_ != nullptr)
            state_->enter(WorkerState::Stage::module, static_cast<int>(i), WorkerState::at_the_end);
        items_.clear();
        const auto start = Clock::now();
        Collector publisher(items_, listener_, last);
        modules_[i]->drain(publisher);
        timings_[i].finish_ms += milliseconds_since(start);
        if (!items_.empty()) flow(i + 1, WorkerState::at_the_end);
    }
    for (std::size_t i = 0; i < modules_.size(); ++i) {
        if (state_ != nullptr)
            state_->enter(WorkerState::Stage::module, static_cast<int>(i), WorkerState::at_the_end);
        const auto start = Clock::now();
        modules_[i]->finish(results);
        timings_[i].finish_ms += milliseconds_since(start);
    }
    if (state_ != nullptr) state_->stage.store(WorkerState::Stage::idle, std::memory_order_relaxed);
}

}  // namespace loopline
