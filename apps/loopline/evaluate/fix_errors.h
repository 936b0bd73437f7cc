/// How far a receiver's own fixes are from the truth: what a path on the Earth has to be better than.
#pragma once

#include <mrpt/obs/CObservationGPS.h>

#include <map>
#include <memory>
#include <string>

#include "api/results.h"
#include "evaluate/association.h"
#include "evaluate/evaluation_reference.h"
#include "gnss/geo_reference.h"

namespace loopline {

/// Fixes with a position, whatever their quality, against the antenna at its lever arm by the truth's pose at
/// the fix's own time.
class FixErrors {
 public:
    /// Null where the truth has no headings, or its place on the Earth is not known.
    static std::unique_ptr<FixErrors> against(const std::shared_ptr<const EvaluationReference>& reference);

    void take(const mrpt::obs::CObservationGPS& observation, StampNs stamp_ns);
    /// gnss_horizontal_rmse_m, gnss_horizontal_max_m, gnss_vertical_rmse_m and gnss_fixes_compared over all
    /// receivers; where there are several, gnss_LABEL_... of each, too. None if no fix has a true pose.
    std::map<std::string, MetricValue> metrics() const;

 private:
    explicit FixErrors(const std::shared_ptr<const EvaluationReference>& reference);

    struct Sums {
        std::uint64_t fixes = 0, heights = 0;
        double horizontal_m2 = 0, vertical_m2 = 0, most_horizontal_m = 0;
        void add(const Eigen::Vector3d& error_m, bool has_height);
        void write(const std::string& prefix, std::map<std::string, MetricValue>& metrics) const;
    };

    std::shared_ptr<const EvaluationReference> reference_;  ///< what truth_ looks into
    ReferencePoses truth_;
    gnss::GeoReference frame_;
    Sums all_;
    std::map<std::string, Sums> by_label_;
};

}  // namespace loopline
