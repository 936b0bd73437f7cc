/// Writes a run directory: one file a format, all of it from the run's record.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "config/experiment.h"
#include "pipeline/run_record.h"

namespace loopline {

/// Writes what `outputs` asks for (metrics.json, config.ini, manifest.json and the feature points of a truth
/// always) into `folder`, which exists; pictures and the report are not its business. Files that the manifest
/// of an earlier run in the same folder lists, and this run doesn't have, are removed: what stands there
/// belongs to one run. A file is written under another name first and then renamed, so that an interrupted
/// run leaves no half file. Values that are not finite reach no file: their record is left out, and the
/// manifest's warnings say how many. Throws CommandError if the folder can't be written.
void write_run_directory(const std::filesystem::path& folder, const RunRecord& record,
                         const OutputSettings& outputs);

/// metrics.json alone, again (after the evaluation, or when pictures took their time).
void write_metrics(const std::filesystem::path& folder, const RunRecord& record);

/// Adds files that were written later (pictures, the report) to the manifest's list; paths relative to
/// `folder`.
void add_to_manifest(const std::filesystem::path& folder, const std::vector<std::string>& files);

}  // namespace loopline
