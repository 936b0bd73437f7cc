/// The bytes of a rawlog, plain or gzip, for mrpt::serialization::archiveFrom(). In place of
/// CFileGZInputStream, which hides why a read came short: this one tells a cut file from damaged bytes and
/// from a wrong gzip checksum, loses none of the bytes before the damage, and costs less (igzip unpacks an
/// intact file; small reads are copies from one buffer, or looks into it).
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "pipeline/file_pieces.h"
#include "pipeline/gzip_unpacker.h"

namespace loopline {

class LogFile {
 public:
    enum class Failure {
        none,
        cut_short,     ///< the file ends inside a read, or inside the gzip stream
        bad_data,      ///< bytes that gzip could not have written
        bad_checksum,  ///< everything unpacked, but the gzip trailer disagrees with it
        io_error,      ///< the system failed to read
    };

    /// Opens the file. Throws CommandError(exit_input_data) with one sentence if it is missing, a directory,
    /// not a regular file, or may not be read.
    explicit LogFile(const std::string& path);
    ~LogFile();
    LogFile(const LogFile&) = delete;
    LogFile& operator=(const LogFile&) = delete;

    /// Nothing more to come: the end, or a failure (see failure()).
    bool at_end() { return next_ == end_ && !append(); }
    Failure failure() const { return failure_; }

    std::uint64_t file_bytes() const { return file_bytes_; }
    /// Of the file, so that it says how far reading has come.
    std::uint64_t file_bytes_read() const { return packed_.bytes_read(); }

    /// For MRPT's archive: exactly `size` bytes, or an exception with failure() set.
    std::size_t Read(void* destination, std::size_t size);
    std::size_t Write(const void*, std::size_t);
    std::string getStreamDescription() const { return path_; }

    /// Looks ahead: makes `wanted` bytes or more ready, or as many as there are, or as a buffer holds. They
    /// stay where they are until the next call of anything but skip().
    std::size_t look_ahead(std::size_t wanted) {
        while (static_cast<std::size_t>(end_ - next_) < wanted && append()) {
        }
        return static_cast<std::size_t>(end_ - next_);
    }
    const unsigned char* ready() const { return next_; }
    /// Passes over bytes that are ready.
    void skip(std::size_t size) { next_ += size; }

 private:
    bool append();
    std::size_t append_plain(unsigned char* to, std::size_t room);
    std::size_t append_unpacked(unsigned char* to, std::size_t room);
    GzipUnpacker::Status unpack_with_zlib(unsigned char* to, std::size_t room, std::size_t& unpacked);
    void open_format();

    std::string path_;
    int descriptor_ = -1;
    std::uint64_t file_bytes_ = 0;
    Failure failure_ = Failure::none;
    bool ended_ = false;
    FilePieces packed_;
    enum class Format { unknown, plain, igzip, zlib } format_ = Format::unknown;
    std::unique_ptr<GzipUnpacker> unpacker_;
    std::uint64_t unpacked_bytes_ = 0;
    std::vector<unsigned char> buffer_;
    const unsigned char* next_ = nullptr;  ///< of the bytes ready for Read()
    const unsigned char* end_ = nullptr;
};

}  // namespace loopline
