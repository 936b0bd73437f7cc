/// A file read from its beginning to its end, piece by piece, through one buffer.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace loopline {

class FilePieces {
 public:
    /// `descriptor` stays the caller's, who keeps it open and reads nothing from it meanwhile.
    explicit FilePieces(int descriptor) : descriptor_(descriptor) {}

    /// What was read and not yet taken.
    const unsigned char* data() const { return buffer_.data() + begin_; }
    std::size_t size() const { return end_ - begin_; }
    void take(std::size_t size) { begin_ += size; }
    /// Reads on, behind what is not yet taken; false if nothing more comes.
    bool fill();
    /// Reads on past the buffer, when all of it is taken.
    std::size_t read(unsigned char* to, std::size_t room);

    /// The system failed to read; else the file has ended where fill() is false.
    bool failed() const { return failed_; }
    std::uint64_t bytes_read() const { return bytes_read_; }

 private:
    int descriptor_;
    std::vector<unsigned char> buffer_;
    std::size_t begin_ = 0, end_ = 0;
    std::uint64_t bytes_read_ = 0;
    bool failed_ = false;
};

}  // namespace loopline
