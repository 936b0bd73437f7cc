/// Loops over beams that the compiler turns into vector instructions.
#pragma once

#include <cstddef>

/// A function with such loops: compiled for any processor and once more for those with AVX2, which take twice
/// as many beams a step; the one that fits is chosen when the program is loaded. Its loops say `omp simd`:
/// their sums may be formed in another order than they are written in. Of gcc only: clang refuses the
/// attribute at definitions that come after a declaration without it.
#if defined(__x86_64__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__)
#define LOOPLINE_VECTORISED __attribute__((target_clones("avx2", "default")))
#else
#define LOOPLINE_VECTORISED
#endif

namespace loopline::lines {

/// Points that the longest vectors hold. Short loops that would end with a few points more are lengthened to
/// a multiple of it, by points that don't count.
constexpr std::size_t vector_points = 4;

}  // namespace loopline::lines
