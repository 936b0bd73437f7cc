#include "pipeline/large_pages.h"

#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__)
#include <malloc.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>

namespace loopline {
namespace {

constexpr std::uintptr_t large_page_bytes = std::uintptr_t{2} << 20;
constexpr int heap_bytes = 256 << 20;    // of address space; memory is taken as it is needed
constexpr int largest_block = 32 << 20;  // the most that malloc() lets in the heap

}  // namespace

void use_large_pages() {
    ::mallopt(M_MMAP_THRESHOLD, largest_block);
    ::mallopt(M_TRIM_THRESHOLD, heap_bytes);
    ::mallopt(M_TOP_PAD, heap_bytes);
    const auto from =
        (reinterpret_cast<std::uintptr_t>(::sbrk(0)) + large_page_bytes - 1) & ~(large_page_bytes - 1);
    void* volatile block = std::malloc(largest_block / 2);  // makes the heap grow, by all of the above
    std::free(block);
    const auto to = reinterpret_cast<std::uintptr_t>(::sbrk(0));
    if (from < to)
        ::madvise(reinterpret_cast<void*>(from), to - from, MADV_HUGEPAGE);  // or it stays as it is
}

void give_back_free_memory() {
    ::malloc_trim(0);
}

}  // namespace loopline
#else

void loopline::use_large_pages() {}
void loopline::give_back_free_memory() {}

#endif
