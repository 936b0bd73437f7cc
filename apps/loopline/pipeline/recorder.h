/// recorded.rawlog: published observations, in observation format, so that another run can take them as its
/// input.
#pragma once

#include <mrpt/obs/CObservation.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "output/gzip_blocks.h"

namespace loopline {

/// How far a recording is, for a checkpoint.
struct RecorderState {
    std::uint64_t file_bytes = 0;     ///< of the file, that are final
    std::uint32_t file_checksum = 0;  ///< CRC-32 of these
    std::string open_block;           ///< what comes after them, not yet compressed
    std::uint64_t recorded = 0;
    std::set<std::string> unseen;
};

class Recorder {
 public:
    /// Records observations whose class (with or without namespace) or sensorLabel is in `wanted`. The file
    /// is made with the first of them, under another name until commit().
    Recorder(std::filesystem::path folder, const std::vector<std::string>& wanted);
    ~Recorder();

    void take(const mrpt::obs::CObservation& observation);
    /// The file is complete: gives it its name. A sentence for each wanted name that nothing was published
    /// under.
    std::vector<std::string> commit();
    std::uint64_t recorded() const { return recorded_; }

    /// What restore() needs beside the file, complete or not, which from now on is never removed.
    RecorderState state();
    /// Goes on where `state` was taken. Throws std::exception if no file of the folder begins as it did then.
    void restore(const RecorderState& state);

 private:
    bool is_wanted(const mrpt::obs::CObservation& observation);
    void write(const mrpt::obs::CObservation& observation);

    std::filesystem::path folder_;
    std::set<std::string> wanted_, unseen_;
    std::unique_ptr<GzipBlocks> file_;
    bool needed_later_ = false;
    std::uint64_t recorded_ = 0;
};

}  // namespace loopline
