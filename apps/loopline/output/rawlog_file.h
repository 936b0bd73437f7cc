/// A rawlog in MRPT's format of observations, gzip: what other programs read too.
#pragma once

#include <mrpt/io/CFileGZOutputStream.h>
#include <mrpt/serialization/CArchive.h>

#include <filesystem>

namespace loopline {

/// Has its name only when it is whole. Every call throws CommandError(exit_configuration) with a sentence if
/// the folder or the disk refuses; one that is destroyed before commit() leaves nothing behind.
class RawlogFile {
 public:
    explicit RawlogFile(std::filesystem::path file);
    ~RawlogFile();
    RawlogFile(const RawlogFile&) = delete;
    RawlogFile& operator=(const RawlogFile&) = delete;

    void write(const mrpt::serialization::CSerializable& object);
    void commit();

 private:
    [[noreturn]] void refuse();

    std::filesystem::path file_, partial_;
    bool whole_ = false;
    mrpt::io::CFileGZOutputStream stream_;
    mrpt::serialization::CArchiveStreamBase<mrpt::io::CFileGZOutputStream> archive_{stream_};
};

}  // namespace loopline
