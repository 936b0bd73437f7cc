/// A few threads that share independent tasks. What each task computes does not depend on which thread takes
/// it, so results don't depend on the number of threads as long as the caller puts them together by task.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace loopline {

class WorkerPool {
 public:
    /// `threads`: the caller's own included; 1 or less: none is started.
    explicit WorkerPool(int threads);
    ~WorkerPool();
    WorkerPool(const WorkerPool&) = delete;
    WorkerPool& operator=(const WorkerPool&) = delete;

    /// task(0) .. task(count - 1), each once; returns when all are done. The tasks throw nothing.
    void run(std::size_t count, const std::function<void(std::size_t)>& task);

 private:
    void work();
    bool take(std::size_t& task);

    std::mutex mutex_;
    std::condition_variable begun_, done_;
    const std::function<void(std::size_t)>* task_ = nullptr;
    std::size_t count_ = 0, next_ = 0, finished_ = 0;
    bool ends_ = false;
    std::vector<std::thread> threads_;
};

}  // namespace loopline
