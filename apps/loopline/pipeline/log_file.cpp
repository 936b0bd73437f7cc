#include "pipeline/log_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <new>
#include <stdexcept>

#include "commands/command.h"

namespace loopline {
namespace {
constexpr std::size_t input_bytes = 128 * 1024, output_bytes = 256 * 1024;
}

LogFile::LogFile(const std::string& path) : path_(path), input_(input_bytes) {
    descriptor_ = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (descriptor_ < 0 && errno == ENOENT)
        throw CommandError(exit_input_data, path + ": there is no such rawlog; check the path");
    if (descriptor_ < 0)
        throw CommandError(exit_input_data,
                           path + ": this rawlog can't be opened (" + std::strerror(errno) + ")");
    struct stat facts {};
    ::fstat(descriptor_, &facts);
    if (!S_ISREG(facts.st_mode)) {
        ::close(descriptor_);
        throw CommandError(
            exit_input_data,
            path + (S_ISDIR(facts.st_mode) ? ": this is a directory; give a rawlog file in it"
                                           : ": this is no regular file; a rawlog is read more than once"));
    }
    file_bytes_ = static_cast<std::uint64_t>(facts.st_size);
    fill_input();
    gzip_ = starts_gzip_member();
    if (!gzip_) return;
    inflating_ = inside_member_ = inflateInit2(&inflater_, 15 + 16) == Z_OK;
    if (!inflating_) throw std::bad_alloc();
    output_.resize(output_bytes);
}

LogFile::~LogFile() {
    if (inflating_) inflateEnd(&inflater_);
    ::close(descriptor_);
}

std::size_t LogFile::Read(void* destination, std::size_t size) {
    auto* to = static_cast<unsigned char*>(destination);
    for (std::size_t missing = size; missing > 0;) {
        if (next_ == end_ && !refill()) {
            if (failure_ == Failure::none) failure_ = Failure::cut_short;
            throw std::runtime_error("the stream ended inside an object");
        }
        const std::size_t part = std::min(missing, static_cast<std::size_t>(end_ - next_));
        std::memcpy(to, next_, part);
        to += part;
        next_ += part;
        missing -= part;
    }
    return size;
}

std::size_t LogFile::Write(const void*, std::size_t) {
    throw std::logic_error("a LogFile is for reading");
}

bool LogFile::fail(Failure failure) {
    failure_ = failure;
    return false;
}

bool LogFile::refill() {
    if (failure_ != Failure::none) return false;
    return gzip_ ? refill_inflated() : refill_plain();
}

/// Appends to what is left of the input; false at the end of the file.
bool LogFile::fill_input() {
    if (inflater_.avail_in > 0) std::memmove(input_.data(), inflater_.next_in, inflater_.avail_in);
    ssize_t count = 0;
    do count = ::read(descriptor_, input_.data() + inflater_.avail_in, input_.size() - inflater_.avail_in);
    while (count < 0 && errno == EINTR);
    inflater_.next_in = input_.data();
    if (count < 0) return fail(Failure::io_error);
    inflater_.avail_in += static_cast<uInt>(count);
    file_bytes_read_ += static_cast<std::uint64_t>(count);
    return count > 0;
}

bool LogFile::starts_gzip_member() const {
    return inflater_.avail_in >= 2 && inflater_.next_in[0] == 0x1f && inflater_.next_in[1] == 0x8b;
}

bool LogFile::refill_plain() {
    if (inflater_.avail_in == 0 && !fill_input()) return false;
    next_ = inflater_.next_in;
    end_ = next_ + inflater_.avail_in;
    inflater_.avail_in = 0;
    return true;
}

bool LogFile::refill_inflated() {
    inflater_.next_out = output_.data();
    inflater_.avail_out = static_cast<uInt>(output_.size());
    while (inflater_.avail_out == output_.size()) {
        if (inflater_.avail_in < 2 && !fill_input() && inflater_.avail_in == 0)
            return failure_ == Failure::none && inside_member_ ? fail(Failure::cut_short) : false;
        if (!inside_member_) {
            // A further member may follow; anything else behind the first is padding, as gzip itself sees it.
            if (!starts_gzip_member()) return false;
            inflateReset(&inflater_);
            inside_member_ = true;
        }
        const int status = inflate(&inflater_, Z_NO_FLUSH);
        if (status == Z_STREAM_END)
            inside_member_ = false;
        else if (status != Z_OK && status != Z_BUF_ERROR) {
            const bool trailer = inflater_.msg != nullptr && std::strstr(inflater_.msg, "check") != nullptr &&
                                 std::strstr(inflater_.msg, "header") == nullptr;
            failure_ = trailer ? Failure::bad_checksum : Failure::bad_data;
            break;
        }
    }
    next_ = output_.data();
    end_ = output_.data() + (output_.size() - inflater_.avail_out);
    return next_ != end_;
}

}  // namespace loopline
