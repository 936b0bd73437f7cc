/// manifest.json: what a run was made from and what it wrote.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/run_record.h"

namespace loopline {

/// Inputs with size and SHA-256, versions, seed, how the run ended, its warnings, those of the writers
/// included, and the files written (paths relative to `folder`).
void write_manifest(const std::filesystem::path& folder, const RunRecord& record,
                    const std::vector<std::string>& writer_warnings, const std::vector<std::string>& files);

/// The files that the manifest in `folder` lists; none if there is no manifest or it is damaged.
std::vector<std::string> files_in_manifest(const std::filesystem::path& folder);

}  // namespace loopline
