/// The contract for readers of other log formats: `loopline import FORMAT IN... --out F.rawlog`. Its
/// parameters become the command's options: `aperture_deg` is given as --aperture-deg.
#pragma once

#include <mrpt/serialization/CSerializable.h>

#include <string>
#include <vector>

#include "api/earth_frame.h"
#include "api/module.h"
#include "api/pose3.h"
#include "api/stamp.h"

namespace loopline {

/// Takes the rawlog's objects in order.
class RawlogSink {
 public:
    virtual ~RawlogSink() = default;
    virtual void write(const mrpt::serialization::CSerializable& object) = 0;
    /// Where the vehicle really was, if the log knows it.
    virtual void true_pose(StampNs /*stamp_ns*/, const Pose3& /*T_map_base*/) {}
    /// Where the frame of the true poses lies on the Earth.
    virtual void true_frame(const EarthFrame& /*frame*/) {}
    /// A sentence for the person: a damaged line that was left out, an assumption.
    virtual void warn(const std::string& sentence) = 0;
};

/// A format, by the name info().name.
class Importer : public Configurable {
    DEFINE_VIRTUAL_MRPT_OBJECT(Importer)
 public:
    /// Whether an input may be a folder.
    virtual bool takes_folders() const { return false; }
    /// Reads all `inputs`, in this order, as one log. Returns one sentence that sums up what came out. Throws
    /// std::runtime_error, with one sentence, if they can't be imported.
    virtual std::string import(const std::vector<std::string>& inputs, RawlogSink& sink) = 0;
};

}  // namespace loopline
