/// An experiment: what one .ini file, with its overrides, asks for. Everything is made, bound and checked
/// before anything runs.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "api/module.h"

namespace loopline {

/// [run]
struct RunSettings {
    std::vector<std::string> rawlogs;  ///< merged by stamp if there are several
    std::vector<std::string> modules;  ///< the chain, in order
    std::vector<std::string> maps;     ///< map builders, drawn from the final trajectory
    std::string trajectory;  ///< the module whose path is the result; empty: the last one that estimates any
    std::uint64_t seed = 0;
    double checkpoint_s = 2;   ///< of CPU time between two checkpoints; 0: none but on interruption
    int checkpoint_items = 0;  ///< a checkpoint after so many items; 0: by time
};

/// [mount]: where sensors sit on the vehicle and what their ranges lack, if the log is wrong about it.
struct MountSettings {
    std::vector<std::string> sensors;  ///< labels; empty: the log is right about all
    double x_m = 0, y_m = 0, z_m = 0;
    double yaw_rad = 0, pitch_rad = 0, roll_rad = 0;
    double range_scale = 1, range_offset_m = 0;  ///< true range = scale x range + offset
    double aperture_rad = 0;                     ///< from the first beam to the last; 0: as the log says
};

/// [outputs]
struct OutputSettings {
    bool trajectory = true;
    bool maps = true;
    bool snapshots = true;
    bool report = true;
    double states_mb = 500;  ///< that states before loops may take; 0: none is kept
    std::vector<std::string>
        record;  ///< classes or sensor labels of published observations to keep in recorded.rawlog
};

/// [evaluation]
struct EvaluationSettings {
    std::string truth;  ///< TUM file, or MRPT's "t x y phi"; empty: none
    bool truth_beside_log =
        true;              ///< if truth is empty: FILE.truth.tum, where the first rawlog is FILE.rawlog
    double truth_point_x_m = 0, truth_point_y_m = 0;  ///< where on the vehicle the truth was taken
    std::string surveyed;  ///< true points and walls; empty: FILE.truth.csv beside a truth FILE.truth.tum
    std::string published_points;  ///< figures of another work for the same points; empty: none
    double scan_duration_s = 0;    ///< of the lasers that see the points
    std::string relations;         ///< relations file of the Kuemmerle metric; empty: none
};

struct Experiment {
    std::string config_path;
    RunSettings run;
    MountSettings mount;
    OutputSettings outputs;
    EvaluationSettings evaluation;
    std::vector<Module::Ptr> modules;           ///< configured, in chain order
    std::vector<MapBuilder::Ptr> map_builders;  ///< configured, as a pattern: duplicate() gives a fresh one
    std::string effective_ini;  ///< every key with its value, commented; reads back to the same experiment
};

/// Loads plugins, reads the file, puts the keys of `overlays` (other .ini files) in the place of its own,
/// applies `overrides` ("section.key=value") and `rawlogs` (instead of [run] rawlog if not empty). Relative
/// paths are taken from the folder of `config_path` whichever file they stand in. All problems are reported
/// together, one sentence a line with file:line and the nearest known name, in one
/// CommandError(exit_configuration).
Experiment load_experiment(const std::string& config_path, const std::vector<std::string>& overrides,
                           const std::vector<std::string>& rawlogs,
                           const std::vector<std::string>& overlays = {});

/// A new map builder with the same parameter values as `pattern`.
MapBuilder::Ptr fresh_map_builder(const MapBuilder& pattern);

}  // namespace loopline
