/// One file of a run directory: written under another name and renamed when it is whole, with numbers
/// formatted without locale and without a stream object.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "api/stamp.h"

namespace loopline {

/// Every call throws CommandError(exit_configuration) with a sentence if the folder or the disk refuses. A
/// file that is destroyed before commit() leaves nothing behind.
class OutputFile {
 public:
    /// Opens ".NAME.partial" beside `file`.
    explicit OutputFile(std::filesystem::path file);
    ~OutputFile();
    OutputFile(const OutputFile&) = delete;
    OutputFile& operator=(const OutputFile&) = delete;

    OutputFile& text(std::string_view characters) { return bytes(characters.data(), characters.size()); }
    OutputFile& character(char c) {
        if (at_ == end_) flush();
        *at_++ = c;
        return *this;
    }
    OutputFile& bytes(const void* data, std::size_t size) {
        if (static_cast<std::size_t>(end_ - at_) < size) return many_bytes(data, size);
        std::memcpy(at_, data, size);
        at_ += size;
        return *this;
    }
    OutputFile& integer(std::int64_t value);
    OutputFile& count(std::uint64_t value);
    /// Shortest decimal text that reads back to the same double; "-0" is written "0". `value` must be finite:
    /// who has a value that may not be leaves its record out and says so.
    OutputFile& number(double value) { return value == 0 ? character('0') : nonzero(value); }
    /// The same for a float, which needs fewer digits.
    OutputFile& number(float value);
    /// Seconds with nine decimals, all of them from the integer.
    OutputFile& seconds(StampNs stamp_ns);

    /// Puts other bytes in place of some that were given before: what only the end of a file tells.
    void overwrite(std::size_t offset, const void* data, std::size_t size);

    /// Writes what is left, closes and renames.
    void commit();

 private:
    OutputFile& nonzero(double value);
    OutputFile& many_bytes(const void* data, std::size_t size);
    /// Room for `size` bytes, few.
    char* room(std::size_t size) {
        if (static_cast<std::size_t>(end_ - at_) < size) flush();
        return at_;
    }
    void flush();
    [[noreturn]] void fail(int error);

    std::filesystem::path file_;
    std::filesystem::path partial_;
    int descriptor_ = -1;
    std::vector<char> buffer_;
    char* at_ = nullptr;  ///< behind what is not yet written
    char* end_ = nullptr;
};

/// A whole file at once.
void write_whole_file(const std::filesystem::path& file, std::string_view content);

}  // namespace loopline
