#include "pipeline/checkpoint_file.h"

#include <fcntl.h>
#include <unistd.h>
#include <zlib.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>

namespace loopline {
namespace {

namespace fs = std::filesystem;

// In front the name of the format, at the end the CRC-32 of all before it.
const std::string format_name = "LOOPLINE CHECKPOINT 2\n";
constexpr std::size_t checksum_bytes = sizeof(std::uint32_t);
constexpr std::size_t checkpoint_buffer_bytes = std::size_t{1} << 18;

std::uint32_t checksum_of(std::uint32_t before, const void* data, std::size_t size) {
    return static_cast<std::uint32_t>(::crc32_z(before, static_cast<const Bytef*>(data), size));
}

}  // namespace

CheckpointSink::CheckpointSink(fs::path file) : file_(std::move(file)), partial_(file_.string() + ".part") {
    buffer_.reserve(checkpoint_buffer_bytes);
    descriptor_ = ::open(partial_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
    if (descriptor_ < 0) fail();
    Write(format_name.data(), format_name.size());
}

CheckpointSink::~CheckpointSink() {
    if (descriptor_ < 0) return;
    ::close(descriptor_);
    std::error_code ignored;
    fs::remove(partial_, ignored);
}

std::size_t CheckpointSink::Write(const void* data, std::size_t size) {
    buffer_.append(static_cast<const char*>(data), size);
    if (buffer_.size() >= checkpoint_buffer_bytes) {
        checksum_ = checksum_of(checksum_, buffer_.data(), buffer_.size());
        flush();
    }
    return size;
}

void CheckpointSink::flush() {
    for (std::size_t done = 0; done < buffer_.size();) {
        const ssize_t written = ::write(descriptor_, buffer_.data() + done, buffer_.size() - done);
        if (written < 0 && errno == EINTR) continue;
        if (written < 0) fail();
        done += static_cast<std::size_t>(written);
    }
    buffer_.clear();
}

void CheckpointSink::commit(Safety safety) {
    checksum_ = checksum_of(checksum_, buffer_.data(), buffer_.size());
    buffer_.append(reinterpret_cast<const char*>(&checksum_), checksum_bytes);
    flush();
    if (safety == Safety::disk && ::fsync(descriptor_) != 0) fail();
    ::close(descriptor_);
    descriptor_ = -1;
    if (::rename(partial_.c_str(), file_.c_str()) != 0) fail();
}

void CheckpointSink::fail() const {
    throw std::runtime_error(file_.string() + " can't be written (" + std::strerror(errno) + ")");
}

CheckpointBytes::CheckpointBytes(const fs::path& file) {
    std::ifstream stream(file, std::ios::binary);
    std::string bytes(std::istreambuf_iterator<char>(stream), {});
    if (!stream.is_open() || stream.bad()) throw std::runtime_error("it can't be read");
    const bool named = bytes.size() >= format_name.size() + checksum_bytes &&
                       bytes.compare(0, format_name.size(), format_name) == 0;
    if (!named) throw std::runtime_error("it is no checkpoint of this version, or damaged at its beginning");
    next_ = format_name.size();
    end_ = bytes.size() - checksum_bytes;
    std::uint32_t stored = 0;
    std::memcpy(&stored, bytes.data() + end_, checksum_bytes);
    if (checksum_of(0, bytes.data(), end_) != stored)
        throw std::runtime_error("its checksum is wrong: bytes of it are damaged or missing");
    bytes_ = std::make_shared<const std::string>(std::move(bytes));
}

std::size_t CheckpointBytes::Read(void* destination, std::size_t size) {
    if (size > end_ - next_) throw std::runtime_error("it ends early");
    std::memcpy(destination, bytes_->data() + next_, size);
    next_ += size;
    return size;
}

}  // namespace loopline
