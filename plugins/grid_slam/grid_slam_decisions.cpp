/// What module "grid_slam" takes from people on its loops, and tells them.
#include <stdexcept>

#include "grid_slam/grid_slam_module.h"

namespace loopline {

using namespace grid_slam;

std::string GridSlamModule::check() const {
    const char* key = "";
    try {
        key = "loops_off ";
        intervals_from_text(without_search_);
        key = "named_loops ";
        named_loops_from_text(named_loops_);
        key = "refuse_loops ";
        refusals_from_text(refused_loops_);
    } catch (const std::invalid_argument& e) {
        return key + std::string(e.what());
    }
    return {};
}

bool GridSlamModule::refuse_alike_before(const std::string& a, const std::string& b, StampNs loop_ns) const {
    return grid_slam::refuse_alike_before(refusals_from_text(a), refusals_from_text(b), loop_ns);
}

std::vector<std::string> GridSlamModule::loop_warnings() const {
    std::vector<std::string> sentences;
    const LoopDecisions& decisions = slam_->decisions();
    const auto span = [&] {
        return " (its scans are from " + seconds_text(decisions.first_ns()) + " to " +
               seconds_text(decisions.last_ns()) + ")";
    };
    for (std::size_t i = 0; i < slam_->loops().size(); ++i) {
        const LoopRecord& record = slam_->loops()[i];
        const LoopName* name = decisions.name_of(i);
        if (name != nullptr && record.decision != LoopRecord::Decision::accepted)
            sentences.push_back("[grid_slam] named_loops: " + name->text +
                                " is not closed: " + record.reason);
    }
    for (const auto& [loop, reason] : decisions.untried())
        sentences.push_back("[grid_slam] named_loops: " + loop->text + " is not closed: " + reason + span());
    for (const Refusal* refusal : decisions.outside())
        sentences.push_back("[grid_slam] " + refusal->text +
                            " refuses nothing: no scan of the log is of that time" + span());
    return sentences;
}

}  // namespace loopline
