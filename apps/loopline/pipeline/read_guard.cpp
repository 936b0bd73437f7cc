#include "pipeline/read_guard.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>

namespace loopline {
namespace {

#if defined(__SANITIZE_ADDRESS__)
constexpr bool can_limit_memory =
    false;  // its shadow memory is terabytes of address space; see the end of this file
#else
constexpr bool can_limit_memory = true;
#endif

constexpr std::uint64_t least_allowance_bytes = std::uint64_t{1} << 30;
/// A log packs to a half or a third, and an object is not the whole log: far above what an intact one needs.
constexpr std::uint64_t allowance_per_file_byte = 8;
/// The rest of the process grows while a log is read: look again after so many objects.
constexpr std::uint64_t objects_per_measurement = 256;

}  // namespace

ReadGuard::ReadGuard(WorkerState* state, int input, std::uint64_t file_bytes)
    : state_(state),
      input_(input),
      allowance_bytes_(std::max(least_allowance_bytes, allowance_per_file_byte * file_bytes)) {
    if (can_limit_memory && getrlimit(RLIMIT_AS, &normal_) == 0)
        statm_ = ::open("/proc/self/statm", O_RDONLY | O_CLOEXEC);
}

ReadGuard::~ReadGuard() {
    lift();
    if (statm_ >= 0) ::close(statm_);
}

void ReadGuard::measure_address_space() {
    std::array<char, 64> text{};
    if (::pread(statm_, text.data(), text.size() - 1, 0) <= 0) return;
    const auto pages = static_cast<std::uint64_t>(std::strtoull(text.data(), nullptr, 10));
    static const auto page_bytes = static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
    lowered_ = normal_;
    lowered_.rlim_cur = std::min<rlim_t>(normal_.rlim_cur, pages * page_bytes + allowance_bytes_);
}

void ReadGuard::enter(std::uint64_t object) {
    if (state_ != nullptr) state_->enter(WorkerState::Stage::reading, input_, object);
    if (statm_ >= 0 && object >= next_measurement_) lower(object);
}

void ReadGuard::lower(std::uint64_t object) {
    next_measurement_ = object + objects_per_measurement;
    measure_address_space();
    if (lowered_.rlim_cur != 0) setrlimit(RLIMIT_AS, &lowered_);
}

void ReadGuard::leave() {
    if (state_ != nullptr) state_->stage.store(WorkerState::Stage::idle, std::memory_order_relaxed);
}

void ReadGuard::lift() {
    if (lowered_.rlim_cur != 0) setrlimit(RLIMIT_AS, &normal_);
    lowered_.rlim_cur = 0;
}

}  // namespace loopline

#if defined(__SANITIZE_ADDRESS__)
/// In place of the limit: a single absurd allocation fails, as it does under RLIMIT_AS; sooner, since the sanitizer marks
/// all of it byte for byte.
extern "C" const char* __asan_default_options() {
    return "max_allocation_size_mb=256:allocator_may_return_null=1:detect_leaks=0";
}
#endif
