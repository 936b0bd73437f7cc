/// Numbers one behind the other, as they lie in a binary file.
#pragma once

#include <cassert>
#include <cstddef>
#include <cstring>

#include "output/output_file.h"

namespace loopline {

static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "swap the bytes here on a big-endian machine");

/// At most 64 bytes.
class BinaryRow {
 public:
    template <class T>
    BinaryRow& add(T value) {
        assert(size_ + sizeof value <= sizeof bytes_);
        std::memcpy(bytes_ + size_, &value, sizeof value);
        size_ += sizeof value;
        return *this;
    }
    void write(OutputFile& out) {
        out.bytes(bytes_, size_);
        size_ = 0;
    }

 private:
    char bytes_[64];
    std::size_t size_ = 0;
};

}  // namespace loopline
