/// recorded.rawlog: published observations, in observation format, so that another run can take them as its
/// input.
#pragma once

#include <mrpt/io/CFileGZOutputStream.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "api/module.h"

namespace loopline {

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

 private:
    bool is_wanted(const mrpt::obs::CObservation& observation);
    void write(const mrpt::obs::CObservation& observation);

    std::filesystem::path folder_;
    std::set<std::string> wanted_, unseen_;
    std::unique_ptr<mrpt::io::CFileGZOutputStream> file_;
    std::uint64_t recorded_ = 0;
};

}  // namespace loopline
