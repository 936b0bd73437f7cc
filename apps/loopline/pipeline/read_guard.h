/// Damaged bytes can make MRPT's readers allocate gigabytes, hang or crash. This lowers the process's memory
/// limit while a log is read, and marks each CArchive::ReadObject() for the supervisor, if there is one. Two
/// system calls around each object would cost a tenth of the reading: the limit is set now and then, a
/// gigabyte above what the process has by then.
#pragma once

#include <sys/resource.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/worker_state.h"

namespace loopline {

/// Where an earlier attempt at reading a file ended badly: stop before that object.
struct ReadLimit {
    std::uint64_t objects = 0;
    std::string reason;  ///< "it crashes the reader"
};

/// How to read: alone (nothing set; a crash in MRPT's reader ends the process), or as a worker under a
/// supervisor.
struct ReadingRules {
    WorkerState* state = nullptr;
    std::vector<std::optional<ReadLimit>> limits;  ///< per input
};

class ReadGuard {
 public:
    /// `file_bytes` sets the memory that one object of the file may take at most.
    ReadGuard(WorkerState* state, int input, std::uint64_t file_bytes);
    ~ReadGuard();
    ReadGuard(const ReadGuard&) = delete;
    ReadGuard& operator=(const ReadGuard&) = delete;

    /// Just before and just after ReadObject().
    void enter(std::uint64_t object);
    void leave();
    /// For an object that needs no guard: the limit, if there is one by now, goes with the process all the
    /// same.
    void pass(std::uint64_t object) {
        if (object >= next_measurement_ && lowered_.rlim_cur != 0) lower(object);
    }
    /// No more objects will be read.
    void lift();

 private:
    void lower(std::uint64_t object);
    void measure_address_space();

    WorkerState* state_;
    int input_;
    std::uint64_t allowance_bytes_;
    int statm_ = -1;
    std::uint64_t next_measurement_ = 0;
    rlimit normal_{}, lowered_{};
};

}  // namespace loopline
