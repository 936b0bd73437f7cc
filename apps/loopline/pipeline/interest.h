/// Which observations a module is given, and which of them its time is told per.
#pragma once

#include <mrpt/rtti/CObject.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "api/module.h"
#include "pipeline/log_facts.h"

namespace loopline {

/// A module is given what it says it needs or uses, by class or base class; one that names nothing is given
/// everything. Its calls in metrics.json count those of its main input, the first class that it needs, so
/// that mean_ms is its time per scan, not per observation; all that it uses, if it needs none of them.
class Interest {
 public:
    enum class Kind { none, some, main };

    explicit Interest(const ModuleInfo& info) : classes_(info.needs), needs_none_(info.needs.empty()) {
        classes_.insert(classes_.end(), info.uses.begin(), info.uses.end());
    }

    Kind in(const mrpt::obs::CObservation& observation) {
        if (classes_.empty()) return Kind::main;
        const auto* of_class = observation.GetRuntimeClass();
        for (const auto& [known, kind] : known_)
            if (known == of_class) return kind;
        known_.emplace_back(of_class, kind_of(of_class));
        return known_.back().second;
    }

 private:
    Kind kind_of(const mrpt::rtti::TRuntimeClassId* of_class) const {
        for (; of_class != nullptr; of_class = of_class->getBaseClass ? of_class->getBaseClass() : nullptr) {
            const auto found =
                std::find(classes_.begin(), classes_.end(), short_class_name(of_class->className));
            if (found != classes_.end())
                return needs_none_ || found == classes_.begin() ? Kind::main : Kind::some;
        }
        return Kind::none;
    }

    std::vector<std::string> classes_;  ///< without namespaces
    bool needs_none_;
    std::vector<std::pair<const mrpt::rtti::TRuntimeClassId*, Kind>> known_;
};

}  // namespace loopline
