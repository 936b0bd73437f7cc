#include "pipeline/file_pieces.h"

#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace loopline {
namespace {
constexpr std::size_t piece_bytes = 128 * 1024;
}

bool FilePieces::fill() {
    if (buffer_.empty()) buffer_.resize(piece_bytes);
    std::memmove(buffer_.data(), data(), size());
    end_ -= begin_;
    begin_ = 0;
    const std::size_t count = read(buffer_.data() + end_, buffer_.size() - end_);
    end_ += count;
    return count > 0;
}

std::size_t FilePieces::read(unsigned char* to, std::size_t room) {
    ssize_t count = 0;
    do count = ::pread(descriptor_, to, room, static_cast<off_t>(bytes_read_));
    while (count < 0 && errno == EINTR);
    failed_ = count < 0;
    if (failed_) return 0;
    bytes_read_ += static_cast<std::uint64_t>(count);
    return static_cast<std::size_t>(count);
}

}  // namespace loopline
