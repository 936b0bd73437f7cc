/// The bytes of a checkpoint, for CArchive: a file that is whole or not there, and whose damage is noticed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>

namespace loopline {

/// Written under another name; commit() gives it its own. Functions throw
/// std::runtime_error, with the system's reason, if folder or disk refuse.
class CheckpointSink {
 public:
    explicit CheckpointSink(std::filesystem::path file);
    ~CheckpointSink();
    CheckpointSink(const CheckpointSink&) = delete;
    CheckpointSink& operator=(const CheckpointSink&) = delete;

    /// What the file outlives: the end of this process, or the end of the power too.
    enum class Safety { file, disk };
    void commit(Safety safety);

    // For MRPT's archive.
    std::size_t Write(const void* data, std::size_t size);
    std::size_t Read(void*, std::size_t) { throw std::logic_error("CheckpointSink is only written"); }
    std::string getStreamDescription() const { return file_.string(); }

 private:
    void flush();
    [[noreturn]] void fail() const;

    std::filesystem::path file_, partial_;
    int descriptor_ = -1;
    std::uint32_t checksum_ = 0;
    std::string buffer_;
};

/// The bytes that a sink was given, once the whole file has proved to be sound. A copy goes on reading by
/// itself where the original stands.
class CheckpointBytes {
 public:
    /// Throws std::runtime_error if the file can't be read, is none of this format, or is damaged.
    explicit CheckpointBytes(const std::filesystem::path& file);

    // For MRPT's archive.
    std::size_t Read(void* destination, std::size_t size);
    std::size_t Write(const void*, std::size_t) { throw std::logic_error("CheckpointBytes is only read"); }
    std::string getStreamDescription() const { return "checkpoint"; }

 private:
    std::shared_ptr<const std::string> bytes_;
    std::size_t next_ = 0, end_ = 0;
};

}  // namespace loopline
