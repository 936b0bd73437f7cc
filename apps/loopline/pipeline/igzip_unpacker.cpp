#include "pipeline/gzip_unpacker.h"

#ifdef LOOPLINE_IGZIP
#include <isa-l/igzip_lib.h>

namespace loopline {
namespace {

class IgzipUnpacker : public GzipUnpacker {
 public:
    explicit IgzipUnpacker(FilePieces& file) : file_(file) { isal_inflate_init(&inflater_); }

    Status unpack(unsigned char* to, std::size_t room, std::size_t& unpacked) override {
        inflater_.next_out = to;
        inflater_.avail_out = static_cast<std::uint32_t>(room);
        Status status = Status::more;
        while (inflater_.avail_out > 0 && status == Status::more) status = step();
        unpacked = room - inflater_.avail_out;
        return status;
    }

 private:
    Status step() {
        if (file_.size() < 2 && !file_.fill() && file_.size() == 0)
            return inside_member_ || file_.failed() ? Status::bad_data : Status::end;
        if (!inside_member_) {
            if (!starts_gzip_member(file_)) return Status::end;
            isal_inflate_reset(&inflater_);
            inflater_.crc_flag = ISAL_GZIP;
            inside_member_ = true;
        }
        const std::uint32_t room_before = inflater_.avail_out;
        inflater_.next_in = const_cast<std::uint8_t*>(file_.data());
        inflater_.avail_in = static_cast<std::uint32_t>(file_.size());
        const int status = isal_inflate(&inflater_);
        const std::size_t taken = file_.size() - inflater_.avail_in;
        file_.take(taken);
        if (status != ISAL_DECOMP_OK) return Status::bad_data;
        if (inflater_.block_state == ISAL_BLOCK_FINISH) {
            inside_member_ = false;
        } else if (taken == 0 && inflater_.avail_out == room_before && !file_.fill()) {
            return Status::bad_data;
        }
        return Status::more;
    }

    FilePieces& file_;
    inflate_state inflater_{};
    bool inside_member_ = false;
};

}  // namespace

std::unique_ptr<GzipUnpacker> make_igzip_unpacker(FilePieces& file) {
    return std::make_unique<IgzipUnpacker>(file);
}

}  // namespace loopline
#else

std::unique_ptr<loopline::GzipUnpacker> loopline::make_igzip_unpacker(FilePieces&) {
    return nullptr;
}

#endif
