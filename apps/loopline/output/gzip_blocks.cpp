#include "output/gzip_blocks.h"

#include <fcntl.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <vector>

namespace loopline {
namespace {

constexpr std::size_t block_bytes = std::size_t{1} << 18;
constexpr int fastest_compression = 1;
constexpr int gzip_member = 15 + 16;  // window of 32 KB, header and trailer of gzip

[[noreturn]] void fail() {
    throw std::runtime_error(std::strerror(errno));
}

std::uint32_t crc_of(std::uint32_t before, const void* data, std::size_t size) {
    return static_cast<std::uint32_t>(::crc32_z(before, static_cast<const Bytef*>(data), size));
}

}  // namespace

GzipBlocks::GzipBlocks(const std::filesystem::path& file) {
    descriptor_ = ::open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
    if (descriptor_ < 0) fail();
}

GzipBlocks::GzipBlocks(const std::filesystem::path& file, std::uint64_t bytes, std::uint32_t checksum,
                       std::string open_block)
    : file_bytes_(bytes), file_checksum_(checksum), block_(std::move(open_block)) {
    descriptor_ = ::open(file.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0666);
    const auto size = static_cast<off_t>(bytes);
    if (descriptor_ < 0) fail();
    if (::ftruncate(descriptor_, size) != 0 || ::lseek(descriptor_, size, SEEK_SET) != size) {
        ::close(descriptor_);
        fail();
    }
}

GzipBlocks::~GzipBlocks() {
    if (descriptor_ >= 0) ::close(descriptor_);
}

std::size_t GzipBlocks::Write(const void* data, std::size_t size) {
    const char* next = static_cast<const char*>(data);
    for (std::size_t left = size; left > 0;) {
        const std::size_t part = std::min(left, block_bytes - block_.size());
        block_.append(next, part);
        next += part;
        left -= part;
        if (block_.size() == block_bytes) write_block();
    }
    return size;
}

void GzipBlocks::write_block() {
    z_stream deflater{};
    if (deflateInit2(&deflater, fastest_compression, Z_DEFLATED, gzip_member, 8, Z_DEFAULT_STRATEGY) != Z_OK)
        throw std::bad_alloc();
    compressed_.resize(deflateBound(&deflater, static_cast<uLong>(block_.size())));
    deflater.next_in = reinterpret_cast<Bytef*>(block_.data());
    deflater.avail_in = static_cast<uInt>(block_.size());
    deflater.next_out = reinterpret_cast<Bytef*>(compressed_.data());
    deflater.avail_out = static_cast<uInt>(compressed_.size());
    deflate(&deflater, Z_FINISH);
    compressed_.resize(deflater.total_out);
    deflateEnd(&deflater);
    for (std::size_t done = 0; done < compressed_.size();) {
        const ssize_t written = ::write(descriptor_, compressed_.data() + done, compressed_.size() - done);
        if (written < 0 && errno == EINTR) continue;
        if (written < 0) fail();
        done += static_cast<std::size_t>(written);
    }
    file_bytes_ += compressed_.size();
    file_checksum_ = crc_of(file_checksum_, compressed_.data(), compressed_.size());
    block_.clear();
}

void GzipBlocks::finish() {
    if (!block_.empty()) write_block();
    const int closed = ::close(descriptor_);
    descriptor_ = -1;
    if (closed != 0) fail();
}

void GzipBlocks::sync() {
    if (::fsync(descriptor_) != 0) fail();
}

bool GzipBlocks::begins_with(const std::filesystem::path& file, std::uint64_t bytes, std::uint32_t checksum) {
    std::ifstream stream(file, std::ios::binary);
    std::vector<char> part(std::size_t{1} << 18);
    std::uint32_t found = 0;
    while (stream && bytes > 0) {
        stream.read(part.data(), static_cast<std::streamsize>(std::min<std::uint64_t>(bytes, part.size())));
        const auto size = static_cast<std::size_t>(stream.gcount());
        found = crc_of(found, part.data(), size);
        bytes -= size;
        if (size == 0) break;
    }
    return stream.is_open() && bytes == 0 && found == checksum;
}

}  // namespace loopline
