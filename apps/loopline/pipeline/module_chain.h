/// Takes every item of the log through the modules. Order: a module sees an item, and for each item that it
/// sees, right after it, what the module before it published on it. So module i+1 gets item, then what module
/// i published on the item, then what module i-1 published, each followed by what module i published on that,
/// and so on: every module has seen everything that a publication is based on, and no thread or clock has a
/// say. What comes back to a module before the one that published it (ModuleInfo::takes_back) does so when
/// the item has passed; what is published on that flows on, but comes back to nobody.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "api/module.h"
#include "pipeline/interest.h"
#include "pipeline/run_record.h"
#include "pipeline/stopwatch.h"
#include "pipeline/worker_state.h"

namespace loopline {

class ModuleChain {
 public:
    /// Called for each published observation, in the order of publication.
    using Listener = std::function<void(const StreamItem&)>;

    /// `state` may be null; it tells the supervisor which module is at work.
    explicit ModuleChain(const std::vector<Module::Ptr>& modules, WorkerState* state = nullptr,
                         Listener listener = {});

    void start(const RunContext& context);
    void process(StreamItem item);
    /// After the last item: drain() in chain order, each followed by the later modules' process() of what it
    /// published, and then finish() in chain order.
    void finish(Results& results);

    const std::vector<Module::Ptr>& modules() const { return modules_; }
    /// When the latest item had passed, by a TickClock.
    std::int64_t latest_tick() const { return latest_tick_; }
    /// In chain order. total_ms is all of process(), calls the observations of a module's main input,
    /// finish_ms drain() and finish() together.
    std::vector<ModuleTiming> timings() const;
    /// Of the part of the log that another process took through them.
    void set_timings(const std::vector<ModuleTiming>& timings) { earlier_timings_ = timings; }

 private:
    class Collector;
    /// What a module took, in ticks.
    struct Ticks {
        std::uint64_t calls = 0;
        std::int64_t total = 0, worst = 0;
    };
    /// Takes `items_` through the modules from `first` on, up to `end`.
    void flow(std::size_t first, std::uint64_t root_sequence, std::size_t end = SIZE_MAX);
    std::size_t insert_published(std::size_t place);
    void keep_for_earlier(std::size_t module);
    void give_back(std::uint64_t root_sequence);

    std::vector<Module::Ptr> modules_;
    std::vector<Interest> interests_;
    std::vector<std::vector<std::string>> takes_back_;  ///< labels, by module
    /// What was published, and the module before that it comes back to.
    std::vector<std::pair<std::size_t, StreamItem>> to_give_back_;
    bool gives_back_ = false;
    TickClock clock_;
    std::int64_t latest_tick_ = 0;
    std::vector<Ticks> ticks_;
    std::vector<double> finish_ms_;
    std::vector<ModuleTiming> earlier_timings_;
    WorkerState* state_;
    Listener listener_;
    std::vector<StreamItem> items_;      ///< that the module at work is given
    std::vector<StreamItem> published_;  ///< on the item at work
};

}  // namespace loopline
