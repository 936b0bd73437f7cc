/// Bytes that a run sets aside until its end, so that memory does not grow with the length of a log.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <vector>

namespace mrpt::serialization {
class CArchive;
}

namespace loopline {

/// Records of one size: appended, and read again in any order. Whole blocks of them lie in a file; without
/// one, and from where on the disk refuses, they stay in memory.
class ScratchFile {
 public:
    explicit ScratchFile(std::size_t record_bytes);
    ~ScratchFile();
    /// A copy is in memory.
    ScratchFile(const ScratchFile& other);
    ScratchFile& operator=(const ScratchFile& other);
    ScratchFile(ScratchFile&& other) noexcept;
    ScratchFile& operator=(ScratchFile&& other) noexcept;

    /// Where blocks go from now on: a file that a checkpoint can refer to, made (with its folder) when the
    /// first block is full. Only while this is empty.
    void keep_in(std::filesystem::path file);
    /// The same, but nobody else ever sees the file.
    void keep_unseen_in(const std::filesystem::path& folder);

    std::uint64_t size() const { return size_; }  ///< records
    void append(const void* record);
    /// Valid until the next call.
    const std::byte* at(std::uint64_t index) const;
    /// The same; `records` that are wanted from there on becomes how many of them lie one after the other.
    const std::byte* at(std::uint64_t index, std::size_t& records) const;
    void overwrite(std::uint64_t index, const void* record);

    /// For a checkpoint: refers to the file, which is safe on disk then, unless the records shall all be in
    /// the archive, or there is no file. Throws std::exception if the disk refuses.
    void save(mrpt::serialization::CArchive& out, bool with_records);
    /// Goes on where save() was called. Throws std::exception if the file does not begin as it did then.
    void load(mrpt::serialization::CArchive& in);

 private:
    using Block = std::unique_ptr<std::byte[]>;
    struct Cached {
        std::uint64_t block = 0;
        Block bytes;  ///< null: none yet
    };
    std::size_t bytes_per_block() const { return record_bytes_ * records_per_block_; }
    void open(bool anew);
    void close();
    bool write(std::uint64_t offset, const std::byte* data, std::size_t size);
    void put_away_full_block();
    const std::byte* from_file(std::uint64_t block) const;

    std::size_t record_bytes_, records_per_block_;
    std::uint64_t size_ = 0;
    std::filesystem::path file_;
    bool unseen_ = false, refused_ = false;
    int descriptor_ = -1;
    std::uint64_t blocks_in_file_ = 0;
    std::uint32_t checksum_ = 0;  ///< CRC-32 of the blocks in the file, as they were appended
    std::vector<Block> blocks_;   ///< those after them
    static constexpr std::size_t cached_blocks = 4;
    mutable Cached cache_[cached_blocks];  ///< block b at b % cached_blocks
};

}  // namespace loopline
