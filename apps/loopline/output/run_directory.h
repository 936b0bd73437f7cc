/// Writes a run directory: one file a format, all of it from the run's record.
#pragma once

#include <filesystem>

#include "config/experiment.h"
#include "pipeline/run_record.h"

namespace loopline {

/// Writes what `outputs` asks for (metrics.json, config.ini and manifest.json always) into `folder`, which exists; pictures and the report are not its business.
/// A file is written under another name first and then renamed, so that an interrupted run leaves no half file.
/// Throws CommandError if the folder can't be written.
void write_run_directory(const std::filesystem::path& folder, const RunRecord& record, const OutputSettings& outputs);

/// metrics.json alone, again (after the evaluation, or when pictures took their time).
void write_metrics(const std::filesystem::path& folder, const RunRecord& record);

}  // namespace loopline
