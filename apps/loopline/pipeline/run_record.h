/// What is known at the end of a run, complete or not: the only thing that the writers see.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "api/results.h"
#include "api/stored_cloud.h"
#include "api/trajectory.h"
#include "evaluate/evaluation_reference.h"
#include "evaluate/feature_points.h"
#include "pipeline/log_facts.h"

namespace loopline {

struct InputRecord {
    std::string path;
    std::uint64_t bytes = 0;
    std::string sha256;         ///< of the file
    std::uint64_t objects = 0;  ///< read before the end or the damage
    std::string damage;         ///< one sentence if the log is damaged; empty if it was read to its end
    bool is_log = true;         ///< else a file that a module reads, which has no objects
};

struct ModuleTiming {
    std::uint64_t calls = 0;  ///< observations of its main input; the other items cost next to nothing
    double total_ms = 0;      ///< with all items
    double worst_ms = 0;      ///< of one item
    double finish_ms = 0;     ///< at the end of the log, not in total_ms
};

struct RunRecord {
    std::string status = "done";  ///< done, interrupted, damaged_input, refused
    int exit_code = 0;
    bool can_resume = false;  ///< interrupted, with a checkpoint
    std::vector<std::string>
        warnings;  ///< sentences: stamps going backwards, two sensors with one label, ...
    std::vector<InputRecord> inputs;
    std::vector<std::string> states;  ///< files kept of moments before loops were closed

    LogFacts facts;
    std::uint64_t scans_read = 0;  ///< laser scans in the log
    std::uint64_t scans_used = 0;  ///< laser scans with a pose in the result
    StampNs first_stamp_ns = 0;
    StampNs last_stamp_ns = 0;
    double wall_s = 0, cpu_s = 0, peak_memory_mb = 0;
    double earlier_wall_s = 0, earlier_cpu_s = 0;  ///< until the checkpoint that this run went on from

    const Trajectory* trajectory = nullptr;  ///< the result; null if no module estimates one
    std::string trajectory_of;               ///< name of the module that estimates it
    const Trajectory* odometry = nullptr;    ///< dead reckoning; null if there is none
    const StoredCloud* cloud = nullptr;      ///< what a module made; null if none does
    bool cloud_on_trajectory = false;        ///< it lies in the frame of `trajectory`
    Results results;                         ///< maps from the final poses, metrics of the modules
    Results odometry_results;                ///< the same maps from dead reckoning, for "before" pictures
    std::map<std::string, ModuleTiming> modules;
    FeaturePointHits::Outcome feature_points;      ///< of a truth that has any
    std::vector<PublishedPoint> published_points;  ///< figures of another work for them

    std::string config_path;
    std::string effective_ini;
    std::uint64_t seed = 0;
};

}  // namespace loopline
