/// The objects of one rawlog, in order, and how the log ended. MRPT's own CRawlog takes every error for the
/// end of the file; this tells them apart, each as one sentence that names the file, and delivers everything
/// before the damage.
#pragma once

#include <mrpt/serialization/CArchive.h>

#include <cstdint>
#include <string>

#include "pipeline/known_objects.h"
#include "pipeline/log_file.h"
#include "pipeline/read_guard.h"

namespace loopline {

enum class LogEnd {
    not_yet,
    clean,
    empty,          ///< no byte, or no object
    junk,           ///< no MRPT object even at the start
    cut_short,      ///< ends inside an object or inside the gzip stream
    unknown_class,  ///< the format has no object length, so nothing after it can be read
    damaged,        ///< bytes that make no object
    checksum,  ///< all objects were read, but the gzip checksum says that some differ from what was written
};

class ArchiveReader {
 public:
    /// Opens the log. Throws CommandError(exit_input_data) with one sentence if it is missing, a directory,
    /// or can't be read.
    explicit ArchiveReader(const std::string& path, const ReadingRules& rules = {}, std::size_t input = 0);

    /// The next object; null when there is none, and then ending() says why.
    mrpt::serialization::CSerializable::Ptr next();

    LogEnd ending() const { return ending_; }
    /// One sentence that names the file; empty while reading and after a clean end.
    const std::string& damage() const { return damage_; }
    std::uint64_t objects() const { return objects_; }
    const std::string& path() const { return path_; }
    std::uint64_t file_bytes() const { return file_.file_bytes(); }
    std::uint64_t file_bytes_read() const { return file_.file_bytes_read(); }

 private:
    mrpt::serialization::CSerializable::Ptr next_known();
    mrpt::serialization::CSerializable::Ptr end(LogEnd ending, const std::string& damage);
    mrpt::serialization::CSerializable::Ptr end_between_objects();
    mrpt::serialization::CSerializable::Ptr end_inside_object(const std::string& reason);
    mrpt::serialization::CSerializable::Ptr end_damaged(const std::string& reason);
    std::string kept() const;

    std::string path_;
    LogFile file_;
    mrpt::serialization::CArchiveStreamBase<LogFile> archive_;
    KnownObjects known_objects_;
    ReadGuard guard_;
    std::optional<ReadLimit> limit_;
    std::uint64_t objects_ = 0;
    LogEnd ending_ = LogEnd::not_yet;
    std::string damage_;
};

}  // namespace loopline
