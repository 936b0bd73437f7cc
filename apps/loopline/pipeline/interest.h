/// Which observations a module is given, and which of them its time is told per.
#pragma once

#include <mrpt/rtti/CObject.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "api/module.h"
#include "api/timed_per.h"
#include "pipeline/log_facts.h"

namespace loopline {

/// A module is given what it says it needs or uses, by class or base class; one that names nothing is given
/// everything. Its calls in metrics.json count those of its main input, so that mean_ms is its time per scan,
/// not per observation: of the classes that it names (api/timed_per.h), else of the first one that it needs;
/// all that it uses, if it needs none of them.
class Interest {
 public:
    enum class Kind { none, some, main };

    explicit Interest(const ModuleInfo& info, const TimedPer* timed = nullptr) : classes_(info.needs) {
        classes_.insert(classes_.end(), info.uses.begin(), info.uses.end());
        main_ = timed != nullptr     ? timed->timed_per()
                : info.needs.empty() ? info.uses
                                     : std::vector<std::string>{info.needs.front()};
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
            const std::string name = short_class_name(of_class->className);
            const auto among = [&name](const std::vector<std::string>& names) {
                return std::find(names.begin(), names.end(), name) != names.end();
            };
            if (among(classes_)) return among(main_) ? Kind::main : Kind::some;
        }
        return Kind::none;
    }

    std::vector<std::string> classes_, main_;  ///< without namespaces
    std::vector<std::pair<const mrpt::rtti::TRuntimeClassId*, Kind>> known_;
};

}  // namespace loopline
