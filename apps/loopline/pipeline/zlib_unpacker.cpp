#include <zlib.h>

#include <cstring>
#include <new>

#include "pipeline/gzip_unpacker.h"

namespace loopline {
namespace {

constexpr int gzip_members = 15 + 16;  // window of 32 KB, header and trailer of gzip

class ZlibUnpacker : public GzipUnpacker {
 public:
    explicit ZlibUnpacker(FilePieces& file) : file_(file) {
        if (inflateInit2(&inflater_, gzip_members) != Z_OK) throw std::bad_alloc();
    }
    ~ZlibUnpacker() override { inflateEnd(&inflater_); }
    ZlibUnpacker(const ZlibUnpacker&) = delete;
    ZlibUnpacker& operator=(const ZlibUnpacker&) = delete;

    Status unpack(unsigned char* to, std::size_t room, std::size_t& unpacked) override {
        inflater_.next_out = to;
        inflater_.avail_out = static_cast<uInt>(room);
        Status status = Status::more;
        while (inflater_.avail_out > 0 && status == Status::more) status = step();
        unpacked = room - inflater_.avail_out;
        return status;
    }

 private:
    Status step() {
        if (file_.size() < 2 && !file_.fill()) {
            if (file_.failed()) return Status::io_error;
            if (file_.size() == 0) return inside_member_ ? rest() : Status::end;
        }
        if (!inside_member_) {
            if (!starts_gzip_member(file_)) return Status::end;
            inflateReset(&inflater_);
            inside_member_ = true;
        }
        inflater_.next_in = const_cast<Bytef*>(file_.data());
        inflater_.avail_in = static_cast<uInt>(file_.size());
        const int status = inflate(&inflater_, Z_NO_FLUSH);
        file_.take(file_.size() - inflater_.avail_in);
        if (status == Z_STREAM_END) inside_member_ = false;
        return status == Z_OK || status == Z_STREAM_END || status == Z_BUF_ERROR ? Status::more : complaint();
    }

    /// What zlib has read but not yet handed out, when no more comes.
    Status rest() {
        const uInt room_before = inflater_.avail_out;
        inflater_.avail_in = 0;
        inflate(&inflater_, Z_SYNC_FLUSH);
        return inflater_.avail_out < room_before ? Status::more : Status::cut_short;
    }

    Status complaint() const {
        const bool trailer = inflater_.msg != nullptr && std::strstr(inflater_.msg, "check") != nullptr &&
                             std::strstr(inflater_.msg, "header") == nullptr;
        return trailer ? Status::bad_checksum : Status::bad_data;
    }

    FilePieces& file_;
    z_stream inflater_{};
    bool inside_member_ = false;
};

}  // namespace

std::unique_ptr<GzipUnpacker> make_zlib_unpacker(FilePieces& file) {
    return std::make_unique<ZlibUnpacker>(file);
}

}  // namespace loopline
