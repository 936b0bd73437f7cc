/// Seeded random numbers: one stream for each purpose, so that a sensor draws the same numbers whatever the
/// others do.
#pragma once

#include <cstdint>
#include <random>
#include <string_view>

namespace loopline::simulation {

class RandomStream {
 public:
    /// Streams of one seed with different purposes are independent.
    RandomStream(std::uint64_t seed, std::string_view purpose) {
        std::uint64_t hash = 14695981039346656037ULL;  // FNV-1a
        for (const char c : purpose) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211ULL;
        const std::uint32_t words[] = {low(seed), high(seed), low(hash), high(hash)};
        std::seed_seq sequence(std::begin(words), std::end(words));
        engine_.seed(sequence);
    }

    /// In [0, 1).
    double uniform() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }
    double uniform(double from, double to) { return from + (to - from) * uniform(); }
    /// In 0 .. `count` - 1.
    int index(int count) { return static_cast<int>(uniform() * count); }
    bool chance(double probability) { return uniform() < probability; }
    double normal(double sigma) { return sigma * normal_(engine_); }

 private:
    static std::uint32_t low(std::uint64_t word) { return static_cast<std::uint32_t>(word); }
    static std::uint32_t high(std::uint64_t word) { return static_cast<std::uint32_t>(word >> 32); }

    std::mt19937_64 engine_;
    std::normal_distribution<double> normal_;
};

}  // namespace loopline::simulation
