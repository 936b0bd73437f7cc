/// Small rawlogs for the tests of the pipeline, written and damaged on purpose.
#pragma once

#include <mrpt/io/CFileGZOutputStream.h>
#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CActionRobotMovement2D.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/serialization/CArchive.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "api/stamp.h"

namespace loopline::testing {

inline const char* const telecom_log =
    "/usr/share/mrpt/datasets/2006-01ENE-21-SENA_Telecom Faculty_one_loop_only.rawlog";

/// A folder of its own for each test, removed at the end.
class Folder {
 public:
    Folder() {
        std::string pattern = (std::filesystem::temp_directory_path() / "loopline_XXXXXX").string();
        path_ = ::mkdtemp(pattern.data());
    }
    ~Folder() {
        std::error_code ignored;
        std::filesystem::remove_all(path_, ignored);
    }
    std::string operator/(const std::string& name) const { return (path_ / name).string(); }
    const std::filesystem::path& path() const { return path_; }

 private:
    std::filesystem::path path_;
};

inline std::string file_bytes(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

/// Lines of a file that are no comment: the poses of a TUM file.
inline std::size_t rows_of(const std::string& path) {
    std::ifstream file(path);
    std::size_t rows = 0;
    for (std::string line; std::getline(file, line);)
        if (!line.empty() && line[0] != '#') ++rows;
    return rows;
}

inline void write_file(const std::string& path, const std::string& bytes) {
    std::ofstream(path, std::ios::binary) << bytes;
}

inline mrpt::obs::CObservation2DRangeScan::Ptr scan(StampNs stamp_ns, const std::string& label = "LASER",
                                                    std::size_t beams = 5, float range_m = 2) {
    auto observation = mrpt::obs::CObservation2DRangeScan::Create();
    observation->timestamp = stamp_ns == 0 ? INVALID_TIMESTAMP : stamp_to_mrpt(stamp_ns);
    observation->sensorLabel = label;
    observation->resizeScanAndAssign(beams, range_m, true);
    return observation;
}

inline mrpt::obs::CActionCollection::Ptr move(double x_m, double y_m, double phi_rad) {
    mrpt::obs::CActionRobotMovement2D action;
    action.computeFromOdometry({x_m, y_m, phi_rad}, {});
    auto actions = mrpt::obs::CActionCollection::Create();
    actions->insert(action);
    return actions;
}

inline mrpt::obs::CSensoryFrame::Ptr frame(const std::vector<mrpt::obs::CObservation::Ptr>& observations) {
    auto result = mrpt::obs::CSensoryFrame::Create();
    for (const auto& observation : observations) result->insert(observation);
    return result;
}

inline void write_log(const std::string& path,
                      const std::vector<mrpt::serialization::CSerializable::Ptr>& objects,
                      int compression = 1) {
    mrpt::io::CFileGZOutputStream file(path, mrpt::io::OpenMode::TRUNCATE, compression);
    auto archive = mrpt::serialization::archiveFrom(file);
    for (const auto& object : objects) archive << *object;
}

/// Runs `part` in a child process, since damaged bytes may crash MRPT's readers: true if it returned true, or
/// crashed.
template <class Part>
bool holds_or_crashes(const Part& part) {
    const pid_t child = ::fork();
    constexpr int part_said_no = 3;  // a sanitizer ends a process with 1
    if (child == 0) ::_exit(part() ? 0 : part_said_no);
    int status = 0;
    ::waitpid(child, &status, 0);
    return !WIFEXITED(status) || WEXITSTATUS(status) != part_said_no;
}

}  // namespace loopline::testing
