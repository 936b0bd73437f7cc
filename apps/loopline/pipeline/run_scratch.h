/// The folder in a run directory for what modules set aside until the end of the run.
#pragma once

#include <filesystem>

namespace loopline {

/// Goes with the object, and the run directory with it if it was not there before and is empty.
class RunScratch {
 public:
    explicit RunScratch(const std::filesystem::path& run_directory);
    ~RunScratch();
    RunScratch(const RunScratch&) = delete;
    RunScratch& operator=(const RunScratch&) = delete;

    /// Made by whoever puts the first file there.
    const std::filesystem::path& folder() const { return folder_; }
    /// A checkpoint refers to its files: it stays.
    void keep() { kept_ = true; }

 private:
    std::filesystem::path folder_;
    bool made_run_directory_, kept_ = false;
};

struct RunSetup;
/// Without a name if the run has none.
std::filesystem::path scratch_folder_of(const RunSetup& setup);

}  // namespace loopline
