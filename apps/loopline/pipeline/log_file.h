/// The bytes of a rawlog, plain or gzip, for mrpt::serialization::archiveFrom(). In place of
/// CFileGZInputStream, which hides why a read came short: this one tells a cut file from damaged bytes and
/// from a wrong gzip checksum, loses none of the bytes before the damage, and costs less (its small reads are
/// copies from one buffer).
#pragma once

#include <zlib.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

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
    bool at_end() { return next_ == end_ && !refill(); }
    Failure failure() const { return failure_; }

    std::uint64_t file_bytes() const { return file_bytes_; }
    /// Of the file, so that it says how far reading has come.
    std::uint64_t file_bytes_read() const { return file_bytes_read_; }

    /// For MRPT's archive: exactly `size` bytes, or an exception with failure() set.
    std::size_t Read(void* destination, std::size_t size);
    std::size_t Write(const void*, std::size_t);
    std::string getStreamDescription() const { return path_; }

 private:
    bool refill();
    bool refill_plain();
    bool refill_inflated();
    bool fill_input();
    bool starts_gzip_member() const;
    bool fail(Failure failure);

    std::string path_;
    int descriptor_ = -1;
    std::uint64_t file_bytes_ = 0, file_bytes_read_ = 0;
    Failure failure_ = Failure::none;
    bool gzip_ = false, inside_member_ = false, inflating_ = false;
    z_stream inflater_{};
    std::vector<unsigned char> input_, output_;
    const unsigned char* next_ = nullptr;  ///< of the bytes ready for Read()
    const unsigned char* end_ = nullptr;
};

}  // namespace loopline
