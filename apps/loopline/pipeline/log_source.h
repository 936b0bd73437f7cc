/// The log as the modules see it: one stream of observations from one or several rawlogs of either format.
/// The order of a file is kept even where its stamps go backwards (reported, never sorted away); several
/// files are merged by stamp.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "api/module.h"
#include "pipeline/archive_reader.h"
#include "pipeline/log_facts.h"
#include "pipeline/mounting.h"
#include "pipeline/object_splitter.h"

namespace loopline {

class LogSource {
 public:
    /// Opens all files. Throws CommandError(exit_input_data) for the first that can't be opened.
    explicit LogSource(const std::vector<std::string>& rawlogs, const ReadingRules& rules = {},
                       const Mounting& mounting = Mounting());

    /// The next observation; false at the end. Every pass over the same files gives the same items with the
    /// same sequences, and damage at the end of a file changes nothing before it. An observation without a
    /// stamp gets the one before it in its file.
    bool next(StreamItem& item);

    const LogFacts& facts() const { return facts_; }
    /// Observations (and odometry increments) kept out because they hold impossible numbers, by reason.
    const std::map<std::string, std::uint64_t>& refusals() const { return refusals_; }
    std::uint64_t refused() const;
    /// One sentence for each thing a user should know: stamps that go backwards or are missing, refused
    /// observations, shared labels. Complete at the end of the log.
    std::vector<std::string> warnings() const;

    std::size_t inputs() const { return inputs_.size(); }
    const ArchiveReader& reader(std::size_t input) const { return inputs_[input]->reader; }
    /// One sentence per damaged file.
    std::vector<std::string> damages() const;
    /// Of all files' bytes, 0 .. 1.
    double fraction_read() const;

 private:
    struct Input {
        Input(const std::string& path, const ReadingRules& rules, std::size_t index)
            : reader(path, rules, index) {}
        ArchiveReader reader;
        ObjectSplitter splitter;
        mrpt::obs::CObservation::Ptr head;  ///< the next observation of this file, already checked
        StampNs head_stamp_ns = 0;
        StampNs merge_key_ns = 0;  ///< latest stamp so far: an early stamp does not overtake the other files
        bool ended = false, any_stamp = false;
        StampNs last_stamp_ns = 0;
        std::uint64_t backwards = 0, missing_stamps = 0;
        StampNs worst_backwards_ns = 0;
    };
    void fill_head(Input& input);
    void stamp_head(Input& input);
    Input* earliest();

    Mounting mounting_;
    std::vector<std::unique_ptr<Input>> inputs_;
    std::map<std::string, std::uint64_t> refusals_;
    std::uint64_t sequence_ = 0;
    LogFacts facts_;
};

}  // namespace loopline
