/// The sections that belong to the host itself, declared like those of the modules.
#pragma once

#include <string>
#include <vector>

#include "config/experiment.h"

namespace loopline {

ParameterTable run_table(RunSettings& settings);
ParameterTable outputs_table(OutputSettings& settings);
ParameterTable mount_table(MountSettings& settings);
ParameterTable evaluation_table(EvaluationSettings& settings);

/// The names of the three, in their order.
const std::vector<std::string>& host_section_names();

}  // namespace loopline
