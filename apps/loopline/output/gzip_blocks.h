/// A gzip file in blocks of equal length, each compressed by itself (RFC 1952 allows for several members):
/// the same content gives the same bytes however it is handed over, and writing can go on at the end of any
/// block in another process.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <stdexcept>
#include <string>

namespace loopline {

class GzipBlocks {
 public:
    /// Makes the file anew. All functions throw std::runtime_error if folder or disk refuse.
    explicit GzipBlocks(const std::filesystem::path& file);
    /// Goes on with a file that was closed, after its first `bytes`, with CRC-32 `checksum`; the rest is cut
    /// off. `open_block` is what follows.
    GzipBlocks(const std::filesystem::path& file, std::uint64_t bytes, std::uint32_t checksum,
               std::string open_block);
    ~GzipBlocks();
    GzipBlocks(const GzipBlocks&) = delete;
    GzipBlocks& operator=(const GzipBlocks&) = delete;

    /// The last block, then the file is closed.
    void finish();
    /// All complete blocks are on the disk, even if the power fails.
    void sync();

    std::uint64_t file_bytes() const { return file_bytes_; }  ///< of complete blocks
    std::uint32_t file_checksum() const { return file_checksum_; }
    const std::string& open_block() const { return block_; }

    // For MRPT's archive.
    std::size_t Write(const void* data, std::size_t size);
    std::size_t Read(void*, std::size_t) { throw std::logic_error("GzipBlocks is only written"); }
    std::string getStreamDescription() const { return "gzip blocks"; }

    /// Whether a file begins with `bytes` bytes of this CRC-32.
    static bool begins_with(const std::filesystem::path& file, std::uint64_t bytes, std::uint32_t checksum);

 private:
    void write_block();

    int descriptor_ = -1;
    std::uint64_t file_bytes_ = 0;
    std::uint32_t file_checksum_ = 0;
    std::string block_, compressed_;
};

}  // namespace loopline
