#include "pipeline/recorder.h"

#include <mrpt/serialization/CArchive.h>

#include "commands/command.h"
#include "pipeline/log_facts.h"

namespace loopline {
namespace {

namespace fs = std::filesystem;
const char* const unfinished_name = "recorded.rawlog.part";
const char* const finished_name = "recorded.rawlog";

}  // namespace

Recorder::Recorder(fs::path folder, const std::vector<std::string>& wanted)
    : folder_(std::move(folder)), wanted_(wanted.begin(), wanted.end()), unseen_(wanted_) {}

Recorder::~Recorder() {
    if (!file_ || needed_later_) return;
    file_.reset();
    std::error_code ignored;
    fs::remove(folder_ / unfinished_name, ignored);
}

bool Recorder::is_wanted(const mrpt::obs::CObservation& observation) {
    const std::string name = observation.GetRuntimeClass()->className;
    bool wanted = false;
    for (const auto& candidate : {name, short_class_name(name), observation.sensorLabel})
        if (wanted_.count(candidate) > 0) {
            unseen_.erase(candidate);
            wanted = true;
        }
    return wanted;
}

void Recorder::take(const mrpt::obs::CObservation& observation) {
    if (wanted_.empty() || !is_wanted(observation)) return;
    try {
        write(observation);
    } catch (const std::exception&) {
        throw CommandError(exit_configuration,
                           (folder_ / unfinished_name).string() + ": can't be written; is the disk full?");
    }
    ++recorded_;
}

void Recorder::write(const mrpt::obs::CObservation& observation) {
    if (!file_) {
        fs::create_directories(folder_);
        file_ = std::make_unique<GzipBlocks>(folder_ / unfinished_name);
    }
    mrpt::serialization::CArchiveStreamBase<GzipBlocks> archive(*file_);
    archive.WriteObject(observation);
}

std::vector<std::string> Recorder::commit() {
    std::vector<std::string> sentences;
    for (const auto& name : unseen_)
        sentences.push_back("[outputs] record names " + name +
                            ", but no module published such an observation");
    if (!file_) return sentences;
    try {
        file_->finish();
        file_.reset();
        fs::rename(folder_ / unfinished_name, folder_ / finished_name);
    } catch (const std::exception&) {
        throw CommandError(exit_configuration,
                           (folder_ / finished_name).string() + ": can't be written; is the disk full?");
    }
    return sentences;
}

RecorderState Recorder::state() {
    RecorderState state;
    state.recorded = recorded_;
    state.unseen = unseen_;
    if (!file_) return state;
    file_->sync();
    needed_later_ = true;
    state.file_bytes = file_->file_bytes();
    state.file_checksum = file_->file_checksum();
    state.open_block = file_->open_block();
    return state;
}

/// The file of a run that was killed stands under its first name, that of one that was interrupted under its
/// last, with more in it than it had at the checkpoint.
void Recorder::restore(const RecorderState& state) {
    recorded_ = state.recorded;
    unseen_ = state.unseen;
    if (recorded_ == 0) return;
    const fs::path unfinished = folder_ / unfinished_name, finished = folder_ / finished_name;
    const auto fits = [&state](const fs::path& file) {
        return GzipBlocks::begins_with(file, state.file_bytes, state.file_checksum);
    };
    if (state.file_bytes > 0 && !fits(unfinished)) {
        if (!fits(finished)) throw std::runtime_error(unfinished.string() + " is missing or damaged");
        fs::copy_file(finished, unfinished, fs::copy_options::overwrite_existing);
    }
    file_ = std::make_unique<GzipBlocks>(unfinished, state.file_bytes, state.file_checksum, state.open_block);
    needed_later_ = true;
}

}  // namespace loopline
