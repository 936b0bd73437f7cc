/// Runs of the program on logs made for the purpose, with the smallest experiment that there is.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "pipeline_logs.h"
#include "support/run_program.h"
#include "support/second.h"

namespace loopline::testing {

using test::second_ns;
constexpr StampNs log_start_ns = 1'600'000'000 * second_ns;

/// An experiment of dead reckoning alone, on a log that the command line names, and a place for its results.
class SmallRun {
 public:
    explicit SmallRun(const std::string& modules = "odometry") {
        ini_ = folder_ / "small.ini";
        write_file(ini_, "[run]\nrawlog = " + std::string(telecom_log) + "\nmodules = " + modules +
                             "\n[outputs]\nmaps = false\nsnapshots = false\nreport = false\n");
    }

    test::ProgramResult run(const std::string& log, std::vector<std::string> more = {}) const {
        std::vector<std::string> arguments{"run", ini_, "--rawlog", log, "--out", out(), "--quiet"};
        arguments.insert(arguments.end(), more.begin(), more.end());
        return test::run_loopline(arguments);
    }

    const Folder& folder() const { return folder_; }
    const std::string& ini() const { return ini_; }
    std::string out() const { return folder_ / "out"; }
    std::string text_of(const std::string& file) const { return file_bytes(out() + "/" + file); }
    nlohmann::json metrics() const {
        const auto text = text_of("metrics.json");
        return text.empty() ? nlohmann::json() : nlohmann::json::parse(text);
    }
    std::size_t rows_of_trajectory() const { return rows_of(out() + "/trajectory.tum"); }

 private:
    Folder folder_;
    std::string ini_;
};

/// Each line of `said` is one sentence of the program; none is a call stack or a prompt.
inline void expect_sentences(const std::string& said, const std::string& log) {
    EXPECT_NE(said.find(log), std::string::npos) << said;
    if (test::built_with_address_sanitizer()) return;
    for (const char* noise : {"Press any key", "backtrace", ".cpp:", "MRPT_END", "terminate called"})
        EXPECT_EQ(said.find(noise), std::string::npos) << said;
}

/// A frame with one scan of `beams` ranges, and the odometry before it.
inline void append_step(std::vector<mrpt::serialization::CSerializable::Ptr>& objects, int step,
                        std::size_t beams = 181) {
    if (step > 0) objects.push_back(move(0.1, 0, 0.01));
    objects.push_back(frame({scan(log_start_ns + step * second_ns / 10, "LASER", beams)}));
}

inline std::vector<mrpt::serialization::CSerializable::Ptr> drive(int steps) {
    std::vector<mrpt::serialization::CSerializable::Ptr> objects;
    for (int i = 0; i < steps; ++i) append_step(objects, i);
    return objects;
}

}  // namespace loopline::testing
