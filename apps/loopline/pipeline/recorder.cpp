#include "pipeline/recorder.h"

#include <mrpt/serialization/CArchive.h>

#include "commands/command.h"
#include "pipeline/log_facts.h"

namespace loopline {
namespace {
constexpr int fastest_compression = 1;
const char* const unfinished_name = "recorded.rawlog.part";
}  // namespace

Recorder::Recorder(std::filesystem::path folder, const std::vector<std::string>& wanted)
    : folder_(std::move(folder)), wanted_(wanted.begin(), wanted.end()), unseen_(wanted_) {}

Recorder::~Recorder() {
    if (!file_) return;
    file_.reset();
    std::error_code ignored;
    std::filesystem::remove(folder_ / unfinished_name, ignored);
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
        std::filesystem::create_directories(folder_);
        file_ = std::make_unique<mrpt::io::CFileGZOutputStream>();
        if (!file_->open((folder_ / unfinished_name).string(), fastest_compression))
            throw std::runtime_error("can't be opened");
    }
    auto archive = mrpt::serialization::archiveFrom(*file_);
    archive.WriteObject(observation);
}

std::vector<std::string> Recorder::commit() {
    std::vector<std::string> sentences;
    for (const auto& name : unseen_)
        sentences.push_back("[outputs] record names " + name +
                            ", but no module published such an observation");
    if (!file_) return sentences;
    file_.reset();
    std::filesystem::rename(folder_ / unfinished_name, folder_ / "recorded.rawlog");
    return sentences;
}

}  // namespace loopline
