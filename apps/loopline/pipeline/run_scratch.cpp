#include "pipeline/run_scratch.h"

#include "pipeline/run.h"

namespace loopline {
namespace fs = std::filesystem;

RunScratch::RunScratch(const fs::path& run_directory) : folder_(run_directory / "scratch") {
    std::error_code none;
    made_run_directory_ = !fs::exists(run_directory, none);
}

RunScratch::~RunScratch() {
    if (kept_) return;
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
    if (made_run_directory_) fs::remove(folder_.parent_path(), ignored);
}

fs::path scratch_folder_of(const RunSetup& setup) {
    return setup.scratch != nullptr ? setup.scratch->folder() : fs::path();
}

}  // namespace loopline
