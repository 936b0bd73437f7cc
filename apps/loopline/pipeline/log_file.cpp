#include "pipeline/log_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <stdexcept>

#include "commands/command.h"

namespace loopline {
namespace {

constexpr std::size_t ready_bytes = 256 * 1024;

/// A descriptor to read from; throws CommandError if there is none to be had.
int opened(const std::string& path) {
    const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (descriptor < 0 && errno == ENOENT)
        throw CommandError(exit_input_data, path + ": there is no such rawlog; check the path");
    if (descriptor < 0)
        throw CommandError(exit_input_data,
                           path + ": this rawlog can't be opened (" + std::strerror(errno) + ")");
    return descriptor;
}

LogFile::Failure failure_of(GzipUnpacker::Status status) {
    switch (status) {
        case GzipUnpacker::Status::cut_short:
            return LogFile::Failure::cut_short;
        case GzipUnpacker::Status::bad_data:
            return LogFile::Failure::bad_data;
        case GzipUnpacker::Status::bad_checksum:
            return LogFile::Failure::bad_checksum;
        case GzipUnpacker::Status::io_error:
            return LogFile::Failure::io_error;
        default:
            return LogFile::Failure::none;
    }
}

}  // namespace

LogFile::LogFile(const std::string& path) : path_(path), descriptor_(opened(path)), packed_(descriptor_) {
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
}

LogFile::~LogFile() {
    ::close(descriptor_);
}

std::size_t LogFile::Read(void* destination, std::size_t size) {
    auto* to = static_cast<unsigned char*>(destination);
    for (std::size_t missing = size; missing > 0;) {
        if (next_ == end_ && !append()) {
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

/// More bytes behind those that are ready; false if no more come, or the buffer is full.
bool LogFile::append() {
    if (ended_ || failure_ != Failure::none) return false;
    if (format_ == Format::unknown) open_format();
    const auto left = static_cast<std::size_t>(end_ - next_);
    if (left == buffer_.size()) return false;
    if (left > 0) std::memmove(buffer_.data(), next_, left);
    unsigned char* const to = buffer_.data() + left;
    const std::size_t room = buffer_.size() - left;
    const std::size_t appended =
        format_ == Format::plain ? append_plain(to, room) : append_unpacked(to, room);
    next_ = buffer_.data();
    end_ = to + appended;
    return appended > 0;
}

void LogFile::open_format() {
    packed_.fill();
    buffer_.resize(ready_bytes);
    next_ = end_ = buffer_.data();
    format_ = Format::plain;
    if (!starts_gzip_member(packed_)) return;
    unpacker_ = make_igzip_unpacker(packed_);
    format_ = unpacker_ ? Format::igzip : Format::zlib;
    if (!unpacker_) unpacker_ = make_zlib_unpacker(packed_);
}

std::size_t LogFile::append_plain(unsigned char* to, std::size_t room) {
    const std::size_t looked_at = std::min(room, packed_.size());
    std::memcpy(to, packed_.data(), looked_at);
    packed_.take(looked_at);
    if (looked_at > 0) return looked_at;
    const std::size_t read = packed_.read(to, room);
    if (packed_.failed()) failure_ = Failure::io_error;
    ended_ = read == 0;
    return read;
}

std::size_t LogFile::append_unpacked(unsigned char* to, std::size_t room) {
    std::size_t unpacked = 0;
    auto status = unpacker_->unpack(to, room, unpacked);
    // What is wrong, and which bytes before it are right: zlib says it.
    if (format_ == Format::igzip && status == GzipUnpacker::Status::bad_data)
        status = unpack_with_zlib(to, room, unpacked);
    unpacked_bytes_ += unpacked;
    failure_ = failure_of(status);
    ended_ = status == GzipUnpacker::Status::end;
    return unpacked;
}

/// Begins anew, and goes on behind the bytes that are already unpacked.
GzipUnpacker::Status LogFile::unpack_with_zlib(unsigned char* to, std::size_t room, std::size_t& unpacked) {
    packed_ = FilePieces(descriptor_);
    unpacker_ = make_zlib_unpacker(packed_);
    format_ = Format::zlib;
    std::vector<unsigned char> known(ready_bytes);
    auto ended_as = GzipUnpacker::Status::more;
    for (std::uint64_t missing = unpacked_bytes_; missing > 0; missing -= unpacked) {
        const auto part = static_cast<std::size_t>(std::min<std::uint64_t>(missing, known.size()));
        ended_as = unpacker_->unpack(known.data(), part, unpacked);
        if (unpacked < part || ended_as != GzipUnpacker::Status::more) break;
    }
    unpacked = 0;
    if (ended_as != GzipUnpacker::Status::more || room == 0) return ended_as;
    return unpacker_->unpack(to, room, unpacked);
}

}  // namespace loopline
