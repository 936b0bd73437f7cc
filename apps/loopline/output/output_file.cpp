#include "output/output_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cassert>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>

#include "commands/command.h"

namespace loopline {
namespace {

constexpr std::size_t buffer_bytes = 1 << 16;
constexpr std::size_t longest_number = 32;  // the shortest text of any double has at most 24 characters
constexpr std::uint64_t ns_per_s = 1'000'000'000;

/// Digits of `value`, with zeros in front up to `width`; returns the end.
char* write_digits(char* first, std::uint64_t value, int width) {
    for (int i = width - 1; i >= 0; --i, value /= 10) first[i] = static_cast<char>('0' + value % 10);
    return first + width;
}

}  // namespace

OutputFile::OutputFile(std::filesystem::path file)
    : file_(std::move(file)), partial_(file_.parent_path() / ("." + file_.filename().string() + ".partial")) {
    descriptor_ = ::open(partial_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
    if (descriptor_ < 0) fail(errno);
    buffer_.resize(buffer_bytes);
    at_ = buffer_.data();
    end_ = at_ + buffer_.size();
}

OutputFile::~OutputFile() {
    if (descriptor_ < 0) return;
    ::close(descriptor_);
    ::unlink(partial_.c_str());
}

void OutputFile::fail(int error) {
    if (descriptor_ >= 0) {
        ::close(descriptor_);
        ::unlink(partial_.c_str());
        descriptor_ = -1;
    }
    throw CommandError(exit_configuration, "can't write " + file_.string() + ": " + std::strerror(error) +
                                               "; free some space there or choose another folder with --out");
}

void OutputFile::flush() {
    for (const char* from = buffer_.data(); from < at_;) {
        const ssize_t written = ::write(descriptor_, from, static_cast<std::size_t>(at_ - from));
        if (written < 0 && errno != EINTR) fail(errno);
        from += std::max<ssize_t>(written, 0);
    }
    at_ = buffer_.data();
}

OutputFile& OutputFile::many_bytes(const void* data, std::size_t size) {
    const char* from = static_cast<const char*>(data);
    while (size > 0) {
        if (at_ == end_) flush();
        const std::size_t part = std::min(size, static_cast<std::size_t>(end_ - at_));
        std::memcpy(at_, from, part);
        at_ += part;
        from += part;
        size -= part;
    }
    return *this;
}

OutputFile& OutputFile::integer(std::int64_t value) {
    char* const first = room(longest_number);
    at_ = std::to_chars(first, first + longest_number, value).ptr;
    return *this;
}

OutputFile& OutputFile::count(std::uint64_t value) {
    char* const first = room(longest_number);
    at_ = std::to_chars(first, first + longest_number, value).ptr;
    return *this;
}

OutputFile& OutputFile::nonzero(double value) {
    assert(std::isfinite(value));
    char* const first = room(longest_number);
    at_ = std::to_chars(first, first + longest_number, value).ptr;
    return *this;
}

OutputFile& OutputFile::number(float value) {
    assert(std::isfinite(value));
    char* const first = room(longest_number);
    at_ = std::to_chars(first, first + longest_number, value + 0.0f).ptr;
    return *this;
}

OutputFile& OutputFile::seconds(StampNs stamp_ns) {
    const std::uint64_t magnitude =
        stamp_ns < 0 ? 0 - static_cast<std::uint64_t>(stamp_ns) : static_cast<std::uint64_t>(stamp_ns);
    char* const first = room(longest_number);
    at_ = first;
    if (stamp_ns < 0) *at_++ = '-';
    at_ = std::to_chars(at_, first + longest_number, magnitude / ns_per_s).ptr;
    *at_++ = '.';
    at_ = write_digits(at_, magnitude % ns_per_s, 9);
    return *this;
}

void OutputFile::overwrite(std::size_t offset, const void* data, std::size_t size) {
    flush();
    const char* from = static_cast<const char*>(data);
    while (size > 0) {
        const ssize_t written = ::pwrite(descriptor_, from, size, static_cast<off_t>(offset));
        if (written < 0 && errno != EINTR) fail(errno);
        const auto done = static_cast<std::size_t>(std::max<ssize_t>(written, 0));
        from += done;
        offset += done;
        size -= done;
    }
}

void OutputFile::commit() {
    flush();
    const int descriptor = descriptor_;
    descriptor_ = -1;
    // Some file systems (quota, network) report a full disk only now.
    const bool closed = ::close(descriptor) == 0;
    if (!closed || std::rename(partial_.c_str(), file_.c_str()) != 0) {
        const int error = errno;
        ::unlink(partial_.c_str());
        fail(error);
    }
}

void write_whole_file(const std::filesystem::path& file, std::string_view content) {
    OutputFile out(file);
    out.text(content).commit();
}

}  // namespace loopline
