/// Do the loops that a run accepted join the right places?
#pragma once

#include <memory>
#include <vector>

#include "evaluate/evaluate_run.h"

namespace loopline {

/// Of the accepted loops both of whose scans have a true pose: loops_right and loops_wrong. A loop is wrong
/// if the final path has its two scans, seen from one another, more than 0.5 m or 5 degrees from where the
/// truth has them: what was joined in the wrong place stays there. Nothing if the truth has no orientation.
RunEvaluation evaluate_loops(const std::vector<LoopDecision>& loops, const Trajectory& trajectory,
                             const std::shared_ptr<const EvaluationReference>& reference);

}  // namespace loopline
