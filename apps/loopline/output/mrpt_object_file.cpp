#include "output/mrpt_object_file.h"

#include <mrpt/io/CMemoryStream.h>
#include <mrpt/io/zip.h>
#include <mrpt/serialization/CArchive.h>

#include <cstdint>
#include <string_view>
#include <vector>

#include "commands/command.h"
#include "output/output_file.h"

namespace loopline {

// MRPT's CFileGZOutputStream does not report a full disk, so the bytes are made in memory.
void write_mrpt_object(const std::filesystem::path& file, const mrpt::serialization::CSerializable& object) {
    constexpr int fast_compression = 2;
    mrpt::io::CMemoryStream stream;
    stream.setAllocBlockSize(1 << 20);
    mrpt::serialization::archiveFrom(stream) << object;
    const auto* begin = static_cast<const std::uint8_t*>(stream.getRawBufferData());
    const std::vector<std::uint8_t> plain(begin, begin + stream.getTotalBytesCount());
    stream.clear();
    std::vector<std::uint8_t> compressed;
    if (!mrpt::io::zip::compress_gz_data_block(plain, compressed, fast_compression))
        throw CommandError(exit_configuration, "can't compress " + file.string() + "; is there memory left?");
    write_whole_file(file, {reinterpret_cast<const char*>(compressed.data()), compressed.size()});
}

}  // namespace loopline
