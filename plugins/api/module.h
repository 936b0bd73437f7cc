/// The contract between the host and the plugins. A plugin library registers Module and MapBuilder classes
/// with MRPT's run-time type system; the host makes them by name, binds their .ini section, and feeds them
/// the log.
#pragma once

#include <mrpt/obs/CObservation.h>
#include <mrpt/rtti/CObject.h>

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "api/parameters.h"
#include "api/results.h"
#include "api/stamp.h"
#include "api/trajectory.h"

namespace mrpt::serialization {
class CArchive;
}

namespace loopline {

/// What a module is, for `describe`, `check` and the error messages.
struct ModuleInfo {
    std::string name;      ///< as in `[run] modules`, and its .ini section
    std::string sentence;  ///< what it does
    std::vector<std::string>
        needs;  ///< class names of observations it can't work without ("CObservation2DRangeScan"); the first
                ///< is the one that its time is told per
    std::vector<std::string> uses;       ///< class names it takes when they are there
    std::vector<std::string> publishes;  ///< class names that it publishes
    /// Labels of observations that modules after it in the chain publish, and that come back to it: after all
    /// of the chain is done with what they are based on.
    std::vector<std::string> takes_back = {};
};

/// One observation on its way through the chain.
struct StreamItem {
    /// Place in the merged log: the same in every pass over it. An observation that a module publishes
    /// carries the sequence of the one that caused it.
    std::uint64_t sequence = 0;
    StampNs stamp_ns = 0;
    mrpt::obs::CObservation::ConstPtr observation;
    bool published = false;  ///< by a module of the chain, and not read from the log
};

/// Takes what a module publishes, to the modules after it in the chain and to the recorder. The observation
/// must carry its own sensorLabel and timestamp.
class Publisher {
 public:
    virtual ~Publisher() = default;
    virtual void publish(const mrpt::obs::CObservation::Ptr& observation) = 0;
    /// As above for one that belongs to an earlier observation (a module that looks ahead holds some back).
    virtual void publish(const mrpt::obs::CObservation::Ptr& observation, std::uint64_t sequence) = 0;
};

struct RunContext {
    int threads = 1;          ///< at most; the result must not depend on it
    std::uint64_t seed = 0;   ///< for whatever draws random numbers
    bool calibrates = false;  ///< the run is for Results::calibrations
    /// For files of what only the end of the run needs (see api/set_aside.h), which a checkpoint may refer to;
    /// made with the first of them, gone after the run. Empty: it stays in memory.
    std::filesystem::path scratch_folder;
};

/// Common to everything that a plugin offers by name: parameters, bound to the object that holds them.
class Configurable : public mrpt::rtti::CObject {
    DEFINE_VIRTUAL_MRPT_OBJECT(Configurable)
 public:
    virtual ModuleInfo info() const = 0;
    /// Declares the parameters of the section info().name, bound to this object, and changes nothing else;
    /// called before start(), more than once if need be.
    virtual ParameterTable parameters() = 0;
    /// After all values were read: what is wrong with their combination, as one sentence; empty if nothing
    /// is.
    virtual std::string check() const { return {}; }
};

/// A step of the chain: takes observations in the log's order, publishes observations.
class Module : public Configurable {
    DEFINE_VIRTUAL_MRPT_OBJECT(Module)
 public:
    virtual void start(const RunContext&) {}
    /// Given are observations of the classes that info() says it needs or uses; all, if it names none.
    virtual void process(const StreamItem& item, Publisher& publisher) = 0;
    /// End of the log: work that was held back; may publish, which the modules after it in the chain still
    /// process before their own finish.
    virtual void drain(Publisher&) {}
    /// After drain() of the whole chain: smoothing, closing loops, handing over maps and figures.
    virtual void finish(Results&) {}
    /// The path that this module estimates, with all its revisions, complete after finish(); null if it
    /// estimates none.
    virtual const Trajectory* trajectory() const { return nullptr; }

    /// Files that it reads beside the log, once its parameters are read: they count as inputs of the run, with
    /// their hashes in the manifest, and what was computed with others is not gone on with.
    virtual std::vector<std::string> input_files() const { return {}; }
    /// What is wrong with these files, as one sentence; empty if nothing is. Asked before anything runs.
    virtual std::string check_input_files() const { return {}; }

    /// Whether a run can be for a calibration of its parameters, which finish() then hands over.
    virtual bool can_calibrate() const { return false; }

    /// Whether the two below are there, or there is no state. A chain makes checkpoints if all its modules
    /// say so.
    virtual bool can_resume() const { return false; }
    /// All that start() and process() made, so that load_state() in another process, after start() with the
    /// same parameters, goes on as if there had been no break: see api/state_archive.h. Called between two
    /// items; nothing that can be seen may change by it. load_state() throws std::exception if what it reads
    /// does not fit.
    virtual void save_state(mrpt::serialization::CArchive&) const {}
    virtual void load_state(mrpt::serialization::CArchive&) {}
};

/// Draws a map from the final trajectory, in a second pass over the log: nobody keeps a private copy of old
/// poses.
class MapBuilder : public Configurable {
    DEFINE_VIRTUAL_MRPT_OBJECT(MapBuilder)
 public:
    /// `trajectory` outlives the builder and is final.
    virtual void start(const RunContext&, const Trajectory& trajectory) = 0;
    virtual void insert(const StreamItem& item) = 0;
    virtual void finish(Results&) = 0;
    /// Whether to draw the map from dead reckoning as well, to show what the estimate corrected.
    virtual bool wants_dead_reckoning() const { return false; }
};

}  // namespace loopline

/// The contract's version: a plugin built against another one is refused with a sentence.
#define LOOPLINE_API_VERSION "loopline-api-6"

/// Once in every plugin library, at file scope, outside any namespace.
#define LOOPLINE_PLUGIN()                                                                         \
    extern "C" __attribute__((visibility("default"))) const char* loopline_plugin_api_version() { \
        return LOOPLINE_API_VERSION;                                                              \
    }                                                                                             \
    static_assert(true, "")
