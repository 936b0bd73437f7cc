/// What a worker process is doing, in memory that it shares with its supervisor, which reads it when the
/// worker died.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>

namespace loopline {

struct WorkerState {
    enum class Stage : int { idle, reading, module, map_builder, writing, drawing, finished };
    static constexpr std::uint64_t at_the_end = ~std::uint64_t{0};

    std::atomic<Stage> stage{Stage::idle};
    std::atomic<int> index{0};  ///< of the input, the module or the map builder at work
    std::atomic<std::uint64_t> position{
        0};  ///< object that is read; sequence that a module works on, or at_the_end
    std::atomic<bool> stop_requested{false};  ///< stop reading, finish, save
    char exception[512] = {};                 ///< what a module threw

    void enter(Stage new_stage, int new_index, std::uint64_t new_position) {
        index.store(new_index, std::memory_order_relaxed);
        position.store(new_position, std::memory_order_relaxed);
        stage.store(new_stage, std::memory_order_relaxed);
    }
};

static_assert(std::atomic<std::uint64_t>::is_always_lock_free, "shared between processes");

}  // namespace loopline
