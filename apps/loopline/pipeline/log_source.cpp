#include "pipeline/log_source.h"

#include <mrpt/obs/CObservationGPS.h>

#include <algorithm>
#include <cstdio>
#include <limits>

#include "api/observation_class.h"
#include "pipeline/observation_gate.h"

namespace loopline {
namespace {

const char* const refused_increments = "odometry increments that are not finite or absurdly long";

std::string seconds_in_words(StampNs duration_ns) {
    char text[32];
    std::snprintf(text, sizeof(text), "%.3f s", static_cast<double>(duration_ns) * 1e-9);
    return text;
}

/// Whether a satellite receiver's fix, stamped with its moment, stands where it came: late by the latency.
bool came_late(const mrpt::obs::CObservation& observation, StampNs now_ns) {
    const auto* fix = as<mrpt::obs::CObservationGPS>(&observation);
    const auto received_ns = fix ? stamp_from_mrpt(fix->originalReceivedTimestamp) : std::nullopt;
    return received_ns && *received_ns >= now_ns;
}

}  // namespace

LogSource::LogSource(const std::vector<std::string>& rawlogs, const ReadingRules& rules,
                     const Mounting& mounting)
    : mounting_(mounting) {
    for (const auto& path : rawlogs) inputs_.push_back(std::make_unique<Input>(path, rules, inputs_.size()));
}

bool LogSource::next(StreamItem& item) {
    for (auto& input : inputs_)
        if (!input->head && !input->ended) fill_head(*input);
    Input* input = earliest();
    if (input == nullptr) return false;
    item.sequence = sequence_++;
    item.stamp_ns = input->head_stamp_ns;
    facts_.add(*input->head, item.stamp_ns);
    item.observation = std::move(input->head);
    input->head.reset();
    return true;
}

/// Of equal stamps, the file named first wins: stable.
LogSource::Input* LogSource::earliest() {
    Input* best = nullptr;
    for (auto& input : inputs_)
        if (input->head && (best == nullptr || input->merge_key_ns < best->merge_key_ns)) best = input.get();
    return best;
}

void LogSource::fill_head(Input& input) {
    while (!input.head) {
        auto observation = input.splitter.pop();
        if (!observation) {
            const auto object = input.reader.next();
            if (object) {
                input.splitter.take(object);
                continue;
            }
            if (input.ended) return;
            input.splitter.end();
            input.ended = true;
            continue;
        }
        mounting_.apply(*observation);
        if (const char* reason = refusal_of(*observation)) {
            ++refusals_[reason];
            continue;
        }
        input.head = std::move(observation);
        stamp_head(input);
    }
}

void LogSource::stamp_head(Input& input) {
    const auto own_stamp_ns = stamp_from_mrpt(input.head->timestamp);
    const bool earlier = own_stamp_ns && input.any_stamp && *own_stamp_ns < input.last_stamp_ns;
    const bool late = earlier && came_late(*input.head, input.last_stamp_ns);
    if (!own_stamp_ns) {
        ++input.missing_stamps;
        input.head->timestamp = stamp_to_mrpt(input.last_stamp_ns);
    } else if (earlier && !late) {
        ++input.backwards;
        // Unsigned: the distance of two damaged stamps may not fit.
        const auto step_ns =
            static_cast<std::uint64_t>(input.last_stamp_ns) - static_cast<std::uint64_t>(*own_stamp_ns);
        input.worst_backwards_ns = static_cast<StampNs>(
            std::max(static_cast<std::uint64_t>(input.worst_backwards_ns),
                     std::min<std::uint64_t>(step_ns, std::numeric_limits<StampNs>::max())));
    }
    input.head_stamp_ns = own_stamp_ns.value_or(input.last_stamp_ns);
    input.merge_key_ns =
        input.any_stamp ? std::max(input.merge_key_ns, input.head_stamp_ns) : input.head_stamp_ns;
    if (!late) input.last_stamp_ns = input.head_stamp_ns;
    input.any_stamp = input.any_stamp || own_stamp_ns;
}

std::uint64_t LogSource::refused() const {
    std::uint64_t count = 0;
    for (const auto& [reason, times] : refusals_) count += times;
    for (const auto& input : inputs_) count += input->splitter.refused_increments();
    return count;
}

std::vector<std::string> LogSource::warnings() const {
    std::vector<std::string> sentences;
    for (const auto& input : inputs_) {
        const std::string& path = input->reader.path();
        if (input->backwards > 0)
            sentences.push_back(path + ": stamps go backwards " + std::to_string(input->backwards) +
                                (input->backwards == 1 ? " time, by " : " times, by up to ") +
                                seconds_in_words(input->worst_backwards_ns) + "; the file's order is kept");
        if (input->missing_stamps > 0)
            sentences.push_back(path + ": " + std::to_string(input->missing_stamps) +
                                " observations have no stamp, and take the one before them");
        if (input->splitter.refused_increments() > 0)
            sentences.push_back(path + ": left out " + std::to_string(input->splitter.refused_increments()) +
                                " " + refused_increments);
    }
    for (const auto& [reason, times] : refusals_)
        sentences.push_back("left out " + std::to_string(times) + " " + reason);
    for (auto& sentence : facts_.label_warnings()) sentences.push_back(std::move(sentence));
    return sentences;
}

std::vector<std::string> LogSource::damages() const {
    std::vector<std::string> sentences;
    for (const auto& input : inputs_)
        if (!input->reader.damage().empty()) sentences.push_back(input->reader.damage());
    return sentences;
}

double LogSource::fraction_read() const {
    double read = 0, all = 0;
    for (const auto& input : inputs_) {
        read += static_cast<double>(input->reader.file_bytes_read());
        all += static_cast<double>(input->reader.file_bytes());
    }
    return all > 0 ? read / all : 1;
}

}  // namespace loopline
