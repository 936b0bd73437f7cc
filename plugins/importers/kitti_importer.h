/// Importer "kitti": scans of the KITTI datasets, and what stands beside them.
#pragma once

#include <string>
#include <vector>

#include "api/importer.h"

namespace loopline {

/// A scan becomes a CObservationPointCloud, its points as they are and in their order, from which rings and
/// times are recovered by whoever reads it (lidar/observation_scan.h). The stamp is KITTI's: when the lidar
/// looks ahead, in the middle of its sweep.
class KittiImporter : public Importer {
    DEFINE_MRPT_OBJECT(KittiImporter, loopline)
 public:
    ModuleInfo info() const override;
    ParameterTable parameters() override;
    bool takes_folders() const override { return true; }
    std::string import(const std::vector<std::string>& inputs, RawlogSink& sink) override;

 private:
    struct Recording;  ///< a folder, and all that is known of it
    Recording recording_in(const std::string& folder, RawlogSink& sink) const;
    void write(const Recording& recording, RawlogSink& sink) const;

    std::string times_, poses_, oxts_;
    double rate_hz_ = 10, start_s_ = 1.3e9;
};

}  // namespace loopline
