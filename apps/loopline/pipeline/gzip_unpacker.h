/// Unpacks the members of a gzip file, one after the other. Two ways of the same: zlib, and igzip, which
/// takes half the time and does not tell precisely what is wrong with a damaged file.
#pragma once

#include <cstddef>
#include <memory>

#include "pipeline/file_pieces.h"

namespace loopline {

class GzipUnpacker {
 public:
    enum class Status {
        more,          ///< to come, perhaps
        end,           ///< of the last member; what is behind it is padding, as gzip itself sees it
        cut_short,     ///< the file ends inside a member
        bad_data,      ///< bytes that gzip could not have written
        bad_checksum,  ///< everything unpacked, but the trailer of a member disagrees with it
        io_error,      ///< the system failed to read
    };
    virtual ~GzipUnpacker() = default;

    /// Unpacks into [to, to + room), all of it unless the status is not `more`; `unpacked` says how much it
    /// was.
    virtual Status unpack(unsigned char* to, std::size_t room, std::size_t& unpacked) = 0;
};

/// The next bytes are the beginning of a gzip member.
inline bool starts_gzip_member(const FilePieces& file) {
    return file.size() >= 2 && file.data()[0] == 0x1f && file.data()[1] == 0x8b;
}

/// `file` stands before the first member, and outlives the unpacker. This one gives every byte before a
/// damage.
std::unique_ptr<GzipUnpacker> make_zlib_unpacker(FilePieces& file);

/// Null if the program was built without igzip. Whatever is not a whole, sound gzip file is `bad_data` for
/// this one, some bytes too early.
std::unique_ptr<GzipUnpacker> make_igzip_unpacker(FilePieces& file);

}  // namespace loopline
