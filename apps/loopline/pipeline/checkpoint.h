/// A checkpoint: all that a run needs to go on where it stood. Not in it is what the log gives again: a
/// resumed run reads the log from its beginning, which is cheap beside estimating, and hands it to the
/// modules from the checkpoint's item on.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "api/stamp.h"
#include "config/experiment.h"
#include "pipeline/checkpoint_file.h"
#include "pipeline/module_chain.h"
#include "pipeline/recorder.h"

namespace loopline {

/// A log, or a file that a module reads, for knowing it again.
struct LogIdentity {
    std::uint64_t bytes = 0;
    std::string sha256;
};

/// A checkpoint that is kept: of the moment before a loop was closed.
struct KeptState {
    std::uint64_t loop = 0;   ///< its number, place in Results::loops from 1
    std::uint64_t items = 0;  ///< of the log, that were seen then
    std::uint64_t bytes = 0;  ///< of the file
};

struct CheckpointHead {
    std::string program;        ///< build_of_this_program() of who made it
    std::string effective_ini;  ///< the configuration
    std::vector<LogIdentity> logs;  ///< of input_paths()
    std::uint64_t items = 0;       ///< of the log, that the chain has seen
    double wall_s = 0, cpu_s = 0;  ///< that the run has taken so far
    std::uint64_t loop = 0;        ///< that is to be closed next, if this is kept for it
    StampNs loop_ns = 0;           ///< of its later scan
    std::vector<KeptState> kept;   ///< of the run so far, in order
};

/// Where the checkpoint of a run directory lies.
std::filesystem::path checkpoint_in(const std::filesystem::path& folder);

/// The logs of an experiment, then the files that its modules read beside them.
std::vector<std::string> input_paths(const Experiment& experiment);

/// Of each of these, in this order.
std::vector<LogIdentity> identities_of(const std::vector<std::string>& paths);

/// Tells one build of the program, its plugins and MRPT from another: only the very same one is sure to give
/// the same bytes.
std::string build_of_this_program();

/// Whether every module of the experiment can go on from a checkpoint; else the names of those that can't.
std::vector<std::string> modules_without_state(const Experiment& experiment);

/// Writes `file` into a folder that exists, replacing it only when the new one is whole. What the modules have
/// set aside in files is not in it. Throws std::exception, with the reason, if that fails.
void write_checkpoint(const std::filesystem::path& file, const CheckpointHead& head, const ModuleChain& chain,
                      Recorder& recorder);

/// One to be kept after the run, which has that in it too, and need not outlive a loss of power.
void write_kept_state(const std::filesystem::path& file, const CheckpointHead& head, const ModuleChain& chain,
                      Recorder& recorder);

/// One of a run that has seen nothing yet: `head.items` is 0. It is not worth waiting for the disk.
void write_beginning(const std::filesystem::path& file, const CheckpointHead& head);

/// "[line_slam] interval_scans = 7, and now 20": the first line in which two configurations differ.
std::string first_difference(const std::string& before, const std::string& now);

/// When the run is complete.
void remove_checkpoint(const std::filesystem::path& folder);

/// A checkpoint that belongs to an experiment.
class Checkpoint {
 public:
    /// Reads the one in `folder`. Throws CommandError(exit_configuration), with one sentence, if there is
    /// none, it is damaged, or it is of another program, configuration or log.
    Checkpoint(const std::filesystem::path& folder, const Experiment& experiment);

    /// A kept one; null if it is not there, damaged, of another program, or `serves` says no to its head.
    static std::shared_ptr<const Checkpoint> kept(const std::filesystem::path& file,
                                                  const std::function<bool(const CheckpointHead&)>& serves);

    const CheckpointHead& head() const { return head_; }
    /// Brings a chain that was started, and a recorder, to where they stood. As above, if it does not fit.
    void restore(ModuleChain& chain, Recorder& recorder) const;

 private:
    explicit Checkpoint(std::filesystem::path file) : file_(std::move(file)) {}
    void read();
    void check(const Experiment& experiment) const;
    [[noreturn]] void refuse(const std::string& clause) const;

    std::filesystem::path file_;
    CheckpointHead head_;
    std::optional<CheckpointBytes> bytes_;  ///< after the head
};

}  // namespace loopline
