#include "api/worker_pool.h"

namespace loopline {

WorkerPool::WorkerPool(int threads) {
    for (int k = 1; k < threads; ++k) threads_.emplace_back([this] { work(); });
}

WorkerPool::~WorkerPool() {
    {
        const std::lock_guard lock(mutex_);
        ends_ = true;
    }
    begun_.notify_all();
    for (std::thread& thread : threads_) thread.join();
}

bool WorkerPool::take(std::size_t& task) {
    if (next_ >= count_) return false;
    task = next_++;
    return true;
}

void WorkerPool::work() {
    std::unique_lock lock(mutex_);
    for (;;) {
        begun_.wait(lock, [this] { return ends_ || next_ < count_; });
        if (ends_) return;
        std::size_t task = 0;
        while (take(task)) {
            const auto& run_task = *task_;
            lock.unlock();
            run_task(task);
            lock.lock();
            if (++finished_ == count_) done_.notify_all();
        }
    }
}

void WorkerPool::run(std::size_t count, const std::function<void(std::size_t)>& task) {
    if (threads_.empty()) {
        for (std::size_t k = 0; k < count; ++k) task(k);
        return;
    }
    std::unique_lock lock(mutex_);
    task_ = &task;
    count_ = count;
    next_ = finished_ = 0;
    begun_.notify_all();
    std::size_t mine = 0;
    while (take(mine)) {
        lock.unlock();
        task(mine);
        lock.lock();
        ++finished_;
    }
    done_.wait(lock, [this] { return finished_ == count_; });
    count_ = next_ = 0;
}

}  // namespace loopline
