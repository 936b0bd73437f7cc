/// MRPT reads flags and enumerations as they stand in the file. A damaged one has a value that its type has
/// not, and to look at it as that type is undefined behaviour: these look at its bytes.
#pragma once

#include <cstring>
#include <type_traits>

namespace loopline {

inline bool is_set(const bool& flag) {
    unsigned char byte = 0;
    std::memcpy(&byte, &flag, sizeof(byte));
    return byte != 0;
}

/// Makes a flag true or false.
inline void settle(bool& flag) {
    flag = is_set(flag);
}

template <class Enum>
std::underlying_type_t<Enum> raw_value(const Enum& value) {
    std::underlying_type_t<Enum> raw{};
    std::memcpy(&raw, &value, sizeof(raw));
    return raw;
}

}  // namespace loopline
