#include "output/mrpt_object_file.h"

#include <mrpt/io/CMemoryStream.h>
#include <mrpt/serialization/CArchive.h>
#include <zlib.h>

#include <string>

#include "commands/command.h"
#include "output/output_file.h"

namespace loopline {

namespace {

std::string gzipped(const void* data, std::size_t size) {
    constexpr int fast_compression = 2, gzip_format = 15 + 16;  // window of 32 KB, header and trailer of gzip
    z_stream deflater{};
    if (deflateInit2(&deflater, fast_compression, Z_DEFLATED, gzip_format, 8, Z_DEFAULT_STRATEGY) != Z_OK)
        return {};
    std::string compressed(deflateBound(&deflater, static_cast<uLong>(size)), '\0');
    deflater.next_in = static_cast<Bytef*>(const_cast<void*>(data));
    deflater.avail_in = static_cast<uInt>(size);
    deflater.next_out = reinterpret_cast<Bytef*>(compressed.data());
    deflater.avail_out = static_cast<uInt>(compressed.size());
    const bool whole = deflate(&deflater, Z_FINISH) == Z_STREAM_END;
    compressed.resize(whole ? deflater.total_out : 0);
    deflateEnd(&deflater);
    return compressed;
}

}  // namespace

// MRPT's CFileGZOutputStream does not report a full disk, so the bytes are made in memory. Its
// compress_gz_data_block() takes a temporary file whose name two processes may share: one of them then gets
// nothing.
void write_mrpt_object(const std::filesystem::path& file, const mrpt::serialization::CSerializable& object) {
    mrpt::io::CMemoryStream stream;
    stream.setAllocBlockSize(1 << 20);
    mrpt::serialization::archiveFrom(stream) << object;
    const std::string compressed = gzipped(stream.getRawBufferData(), stream.getTotalBytesCount());
    if (compressed.empty())
        throw CommandError(exit_configuration, "can't compress " + file.string() + "; is there memory left?");
    write_whole_file(file, compressed);
}

}  // namespace loopline
