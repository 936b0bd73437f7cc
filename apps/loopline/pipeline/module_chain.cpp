#include "pipeline/module_chain.h"

#include <algorithm>
#include <iterator>

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
    : modules_(modules),
      ticks_(modules.size()),
      finish_ms_(modules.size()),
      earlier_timings_(modules.size()),
      state_(state),
      listener_(std::move(listener)) {
    for (const auto& module : modules_) {
        const ModuleInfo info = module->info();
        interests_.emplace_back(info, dynamic_cast<const TimedPer*>(module.get()));
        takes_back_.push_back(info.takes_back);
    }
}

void ModuleChain::start(const RunContext& context) {
    for (const auto& module : modules_) module->start(context);
}

void ModuleChain::process(StreamItem item) {
    const std::uint64_t sequence = item.sequence;
    items_.clear();
    items_.push_back(std::move(item));
    flow(0, sequence);
    give_back(sequence);
}

/// Of what `module` has just published.
void ModuleChain::keep_for_earlier(std::size_t module) {
    for (std::size_t i = 0; i < module; ++i)
        for (const StreamItem& item : published_)
            for (const std::string& label : takes_back_[i])
                if (item.observation->sensorLabel == label) to_give_back_.emplace_back(i, item);
}

void ModuleChain::give_back(std::uint64_t root_sequence) {
    if (to_give_back_.empty()) return;
    const auto items = std::move(to_give_back_);
    to_give_back_.clear();
    gives_back_ = true;
    for (const auto& [module, item] : items) {
        items_.clear();
        items_.push_back(item);
        flow(module, root_sequence, module + 1);
        items_.erase(items_.begin());  // which the others have seen
        flow(module + 1, root_sequence);
    }
    gives_back_ = false;
}

/// Moves what was published to `place` of the items; returns how much it was.
std::size_t ModuleChain::insert_published(std::size_t place) {
    const std::size_t count = published_.size();
    if (place == items_.size())
        for (StreamItem& item : published_) items_.push_back(std::move(item));
    else
        items_.insert(items_.begin() + static_cast<std::ptrdiff_t>(place),
                      std::make_move_iterator(published_.begin()), std::make_move_iterator(published_.end()));
    published_.clear();
    return count;
}

void ModuleChain::flow(std::size_t first, std::uint64_t root_sequence, std::size_t end) {
    auto before = clock_.now();  // the end of one call is the beginning of the next: clocks cost, too
    for (std::size_t i = first; i < std::min(end, modules_.size()); ++i) {
        if (state_ != nullptr) state_->enter(WorkerState::Stage::module, static_cast<int>(i), root_sequence);
        auto& ticks = ticks_[i];
        for (std::size_t k = 0; k < items_.size(); ++k) {
            const Interest::Kind interest = interests_[i].in(*items_[k].observation);
            if (interest == Interest::Kind::none) continue;
            Collector publisher(published_, listener_, items_[k]);
            modules_[i]->process(items_[k], publisher);
            const auto after = clock_.now(), elapsed = after - before;
            before = after;
            if (!gives_back_) keep_for_earlier(i);
            ticks.calls += interest == Interest::Kind::main ? 1 : 0;
            ticks.total += elapsed;
            ticks.worst = std::max(ticks.worst, elapsed);
            k += insert_published(k + 1);  // which is not for this module
        }
    }
    latest_tick_ = before;
    if (state_ != nullptr) state_->stage.store(WorkerState::Stage::idle, std::memory_order_relaxed);
}

void ModuleChain::finish(Results& results) {
    StreamItem last;
    for (std::size_t i = 0; i < modules_.size(); ++i) {
        if (state_ != nullptr)
            state_->enter(WorkerState::Stage::module, static_cast<int>(i), WorkerState::at_the_end);
        items_.clear();
        const auto start = Clock::now();
        Collector publisher(published_, listener_, last);
        modules_[i]->drain(publisher);
        finish_ms_[i] += milliseconds_since(start);
        keep_for_earlier(i);
        if (insert_published(0) == 0) continue;
        flow(i + 1, WorkerState::at_the_end);
        give_back(WorkerState::at_the_end);
    }
    for (std::size_t i = 0; i < modules_.size(); ++i) {
        if (state_ != nullptr)
            state_->enter(WorkerState::Stage::module, static_cast<int>(i), WorkerState::at_the_end);
        const auto start = Clock::now();
        const bool placed_before = results.earth.has_value();
        modules_[i]->finish(results);
        if (!placed_before && results.earth) results.earth_by = modules_[i]->info().name;
        finish_ms_[i] += milliseconds_since(start);
    }
    if (state_ != nullptr) state_->stage.store(WorkerState::Stage::idle, std::memory_order_relaxed);
}

std::vector<ModuleTiming> ModuleChain::timings() const {
    const double ms_per_tick = clock_.milliseconds_per_tick();
    std::vector<ModuleTiming> timings = earlier_timings_;
    for (std::size_t i = 0; i < timings.size(); ++i) {
        timings[i].calls += ticks_[i].calls;
        timings[i].total_ms += ms_per_tick * static_cast<double>(ticks_[i].total);
        timings[i].worst_ms =
            std::max(timings[i].worst_ms, ms_per_tick * static_cast<double>(ticks_[i].worst));
        timings[i].finish_ms += finish_ms_[i];
    }
    return timings;
}

}  // namespace loopline
