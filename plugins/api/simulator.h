/// The contract for what makes logs: `loopline simulate SCENARIO.ini --out F.rawlog`. A scenario is an .ini
/// file with the sections of one simulator; they are declared like those of a module.
#pragma once

#include <mrpt/obs/CObservation.h>

#include <cstddef>
#include <string>
#include <vector>

#include "api/module.h"
#include "api/pose3.h"
#include "api/stamp.h"

namespace loopline {

/// A line of FILE.truth.csv: what results are compared with beside the path.
struct TruthRow {
    std::string kind;  ///< "point", "wall", "level", or a sensor's own: "imu_bias"
    int number = 0;
    std::vector<double> values;  ///< point: x y; wall: x1 y1 x2 y2 bottom top; level: z; map frame, m; others
                                 ///< as the simulator's page says
};

/// Takes a simulated log in the order of its stamps.
class SimulationSink {
 public:
    virtual ~SimulationSink() = default;
    virtual void observation(const mrpt::obs::CObservation& observation) = 0;
    /// The true pose of the vehicle at a scan.
    virtual void true_pose(StampNs stamp_ns, const Pose3& T_map_base) = 0;
    virtual void truth(const TruthRow& row) = 0;
    /// How much of the log's `total_s` is there.
    virtual void progress(double done_s, double total_s) = 0;
    /// A sentence for the person.
    virtual void note(const std::string& sentence) = 0;
};

/// What is wrong with a scenario whose values are each good by themselves.
struct ScenarioProblem {
    std::string section;
    std::string key;       ///< empty: the section as a whole
    std::size_t row = 0;   ///< of a key that may stand several times
    std::string sentence;  ///< a clause that fits after the key, or after the section
};

/// info().name is the section that every scenario has, with the seed.
class Simulator : public Configurable {
    DEFINE_VIRTUAL_MRPT_OBJECT(Simulator)
 public:
    /// All sections of a scenario, bound to this object; that of parameters() comes first.
    virtual std::vector<ParameterTable> sections() = 0;
    /// After all values were read.
    virtual std::vector<ScenarioProblem> check_scenario() = 0;
    /// Makes the whole log. Throws std::runtime_error, with one sentence, if the scenario can't be simulated.
    virtual void simulate(SimulationSink& sink) = 0;
};

}  // namespace loopline
