#include "api/scratch_file.h"

#include <fcntl.h>
#include <mrpt/serialization/CArchive.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <cassert>
#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <string>
#include <utility>

namespace loopline {
namespace {

namespace fs = std::filesystem;
constexpr std::size_t block_bytes = std::size_t{1} << 14;  // about

std::uint32_t checksum_of(std::uint32_t before, const std::byte* data, std::size_t size) {
    return static_cast<std::uint32_t>(::crc32_z(before, reinterpret_cast<const Bytef*>(data), size));
}

/// All of them, or false.
bool read_all(int descriptor, std::uint64_t offset, std::byte* data, std::size_t size) {
    for (std::size_t done = 0; done < size;) {
        const ssize_t got = ::pread(descriptor, data + done, size - done, static_cast<off_t>(offset + done));
        if (got < 0 && errno == EINTR) continue;
        if (got <= 0) return false;
        done += static_cast<std::size_t>(got);
    }
    return true;
}

}  // namespace

ScratchFile::ScratchFile(std::size_t record_bytes)
    : record_bytes_(record_bytes), records_per_block_(std::max<std::size_t>(1, block_bytes / record_bytes)) {}

ScratchFile::~ScratchFile() {
    close();
}

ScratchFile::ScratchFile(const ScratchFile& other) : ScratchFile(other.record_bytes_) {
    for (std::uint64_t i = 0; i < other.size(); ++i) append(other.at(i));
}

ScratchFile& ScratchFile::operator=(const ScratchFile& other) {
    return *this = ScratchFile(other);
}

ScratchFile::ScratchFile(ScratchFile&& other) noexcept : ScratchFile(other.record_bytes_) {
    *this = std::move(other);
}

ScratchFile& ScratchFile::operator=(ScratchFile&& other) noexcept {
    std::swap(record_bytes_, other.record_bytes_);
    std::swap(records_per_block_, other.records_per_block_);
    std::swap(size_, other.size_);
    std::swap(file_, other.file_);
    std::swap(unseen_, other.unseen_);
    std::swap(refused_, other.refused_);
    std::swap(descriptor_, other.descriptor_);
    std::swap(blocks_in_file_, other.blocks_in_file_);
    std::swap(checksum_, other.checksum_);
    std::swap(blocks_, other.blocks_);
    std::swap(cache_, other.cache_);
    return *this;
}

void ScratchFile::keep_in(fs::path file) {
    assert(size_ == 0);
    file_ = std::move(file);
}

void ScratchFile::keep_unseen_in(const fs::path& folder) {
    assert(size_ == 0);
    if (folder.empty()) return;
    file_ = folder / ("unseen" + std::to_string(::getpid()));
    unseen_ = true;
}

/// Leaves it closed where the system refuses.
void ScratchFile::open(bool anew) {
    std::error_code ignored;
    fs::create_directories(file_.parent_path(), ignored);
    descriptor_ = ::open(file_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | (anew ? O_TRUNC : 0), 0666);
    if (descriptor_ >= 0 && unseen_) ::unlink(file_.c_str());
}

void ScratchFile::close() {
    if (descriptor_ >= 0) ::close(descriptor_);
    descriptor_ = -1;
}

bool ScratchFile::write(std::uint64_t offset, const std::byte* data, std::size_t size) {
    if (descriptor_ < 0) open(true);
    if (descriptor_ < 0) return false;
    for (std::size_t done = 0; done < size;) {
        const ssize_t written =
            ::pwrite(descriptor_, data + done, size - done, static_cast<off_t>(offset + done));
        if (written < 0 && errno == EINTR) continue;
        if (written < 0) return false;
        done += static_cast<std::size_t>(written);
    }
    return true;
}

void ScratchFile::append(const void* record) {
    const std::size_t place = size_ % records_per_block_;
    if (place == 0) blocks_.emplace_back(new std::byte[bytes_per_block()]);
    std::memcpy(blocks_.back().get() + place * record_bytes_, record, record_bytes_);
    ++size_;
    if (place + 1 == records_per_block_) put_away_full_block();
}

void ScratchFile::put_away_full_block() {
    if (file_.empty() || refused_) return;
    const std::byte* block = blocks_.back().get();
    refused_ = !write(blocks_in_file_ * bytes_per_block(), block, bytes_per_block());
    if (refused_) return;
    checksum_ = checksum_of(checksum_, block, bytes_per_block());
    Cached& slot = cache_[blocks_in_file_ % cached_blocks];  // what is new is what is asked for most
    slot.block = blocks_in_file_++;
    slot.bytes = std::move(blocks_.back());
    blocks_.pop_back();
}

const std::byte* ScratchFile::from_file(std::uint64_t block) const {
    Cached& slot = cache_[block % cached_blocks];
    if (slot.bytes && slot.block == block) return slot.bytes.get();
    if (!slot.bytes) slot.bytes.reset(new std::byte[bytes_per_block()]);
    slot.block = block;
    if (!read_all(descriptor_, block * bytes_per_block(), slot.bytes.get(), bytes_per_block())) {
        slot.bytes.reset();
        throw std::runtime_error(file_.string() + " can't be read again");
    }
    return slot.bytes.get();
}

const std::byte* ScratchFile::at(std::uint64_t index) const {
    assert(index < size_);
    const std::uint64_t block = index / records_per_block_;
    const std::byte* bytes =
        block < blocks_in_file_ ? from_file(block) : blocks_[block - blocks_in_file_].get();
    return bytes + index % records_per_block_ * record_bytes_;
}

const std::byte* ScratchFile::at(std::uint64_t index, std::size_t& records) const {
    records = std::min(records, records_per_block_ - index % records_per_block_);
    return at(index);
}

void ScratchFile::overwrite(std::uint64_t index, const void* record) {
    std::memcpy(const_cast<std::byte*>(at(index)), record, record_bytes_);
    if (index / records_per_block_ < blocks_in_file_ &&
        !write(index * record_bytes_, static_cast<const std::byte*>(record), record_bytes_))
        throw std::runtime_error(file_.string() + " can't be written; is the disk full?");
}

void ScratchFile::save(mrpt::serialization::CArchive& out, bool with_records) {
    const bool refers = !with_records && !file_.empty() && !unseen_;
    out << refers << size_;
    if (!refers) {
        for (std::uint64_t i = 0; i < size_; ++i) out.WriteBuffer(at(i), record_bytes_);
        return;
    }
    if (refused_) throw std::runtime_error(file_.string() + " can't be written");
    const std::size_t open_bytes = size_ % records_per_block_ * record_bytes_;
    std::uint32_t checksum = checksum_;
    if (open_bytes > 0) {
        checksum = checksum_of(checksum, blocks_.back().get(), open_bytes);
        if (!write(blocks_in_file_ * bytes_per_block(), blocks_.back().get(), open_bytes))
            throw std::runtime_error(file_.string() + " can't be written (" + std::strerror(errno) + ")");
    }
    if (descriptor_ >= 0 && ::fdatasync(descriptor_) != 0)
        throw std::runtime_error(file_.string() + " can't be written (" + std::strerror(errno) + ")");
    out << checksum;
}

void ScratchFile::load(mrpt::serialization::CArchive& in) {
    assert(size_ == 0);
    bool refers = false;
    std::uint64_t size = 0;
    in >> refers >> size;
    if (!refers) {
        std::vector<std::byte> record(record_bytes_);
        for (std::uint64_t i = 0; i < size; ++i) {
            in.ReadBuffer(record.data(), record_bytes_);
            append(record.data());
        }
        return;
    }
    std::uint32_t checksum = 0;
    in >> checksum;
    if (size == 0) return;
    const auto damaged = [this] { return std::runtime_error(file_.string() + " is missing or damaged"); };
    std::error_code none;
    if (!fs::exists(file_, none)) throw damaged();
    open(false);
    // The records themselves are where they were; the last block, which is not full, is needed in memory.
    blocks_in_file_ = size / records_per_block_;
    const std::size_t open_bytes = size % records_per_block_ * record_bytes_;
    Block block(new std::byte[bytes_per_block()]);
    for (std::uint64_t b = 0; b < blocks_in_file_; ++b) {
        if (!read_all(descriptor_, b * bytes_per_block(), block.get(), bytes_per_block())) throw damaged();
        checksum_ = checksum_of(checksum_, block.get(), bytes_per_block());
    }
    if (!read_all(descriptor_, blocks_in_file_ * bytes_per_block(), block.get(), open_bytes)) throw damaged();
    if (checksum_of(checksum_, block.get(), open_bytes) != checksum) throw damaged();
    if (open_bytes > 0) blocks_.push_back(std::move(block));
    size_ = size;
}

}  // namespace loopline
