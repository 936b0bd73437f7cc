/// The parts of the report, each as HTML; empty where the run has nothing to show.
#pragma once

#include <string>

#include "render/report/run_files.h"

namespace loopline {

/// Name of the run, how it ended, where and when its data are from.
std::string header_section(const RunFiles& run);
/// What is wrong, first: refused estimates, damaged input, warnings.
std::string alerts_section(const RunFiles& run);
/// The figures that one asks for first; all others in a table that is folded away.
std::string figures_section(const RunFiles& run);
/// Feature points against their true places.
std::string feature_points_section(const RunFiles& run);
/// The snapshots, embedded.
std::string pictures_section(const RunFiles& run);
/// Places where the path was thought to meet itself, and pictures of the corrections; only of a run that has
/// any.
std::string loops_section(const RunFiles& run);
/// Trajectory, standard deviations over time, difference to dead reckoning over distance.
std::string plots_section(const RunFiles& run);
std::string modules_section(const RunFiles& run);
std::string inputs_section(const RunFiles& run);
std::string config_section(const RunFiles& run);
std::string files_section(const RunFiles& run);

/// The run's name for titles: that of its .ini, or of its folder.
std::string run_name(const RunFiles& run);

}  // namespace loopline
