/// Memory that is about to be read, asked for ahead: while it is on its way others are computed. What is
/// looked up at random in tables larger than the caches waits for little else.
#pragma once

#include <cstddef>

namespace loopline {

/// `object` may be null.
template <class T>
inline void fetch(const T* object) {
    if (object == nullptr) return;
    constexpr std::size_t line_bytes = 64;
    const auto* const bytes = reinterpret_cast<const char*>(object);
    for (std::size_t at = 0; at < sizeof(T); at += line_bytes) __builtin_prefetch(bytes + at);
}

}  // namespace loopline
