/// What `loopline check` says about an experiment and its logs.
#pragma once

#include <string>
#include <vector>

#include "commands/command.h"
#include "commands/log_survey.h"
#include "config/experiment.h"
#include "pipeline/log_source.h"

namespace loopline {

/// What a module or map builder needs, and where it comes from.
struct NeedsReport {
    std::vector<std::string> lines;    ///< one for each module and map builder that needs anything
    std::vector<std::string> missing;  ///< a sentence for each need of a module that nothing meets
    std::vector<std::string> undrawn;  ///< a sentence for each map that the log doesn't hold the data for
};
/// An observation class comes from the log, or from a module that stands earlier in the chain. Maps are drawn
/// from the log alone.
NeedsReport needs_report(const Experiment& experiment, const LogFacts& facts);

struct CheckReport {
    std::string text;
    ExitCode verdict = exit_done;  ///< exit_input_data if the log is damaged, empty, or lacks what is needed
};
/// `source` has been read to its end, and `survey` saw every item.
CheckReport check_report(const Experiment& experiment, const LogSource& source, const LogSurvey& survey,
                         std::size_t width);

}  // namespace loopline
