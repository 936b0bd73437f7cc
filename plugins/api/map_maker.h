/// What a module that makes a cloud in its pass over the log offers beside Module: so that the host can leave
/// the work out, and write the cloud. The host finds it by a cast.
#pragma once

#include <string>

#include "api/stored_cloud.h"

namespace loopline {

class MapMaker {
 public:
    virtual ~MapMaker() = default;
    /// Before start(), which is called all the same: nobody wants the map, so that it costs nothing.
    virtual void leave_out_map() = 0;
    /// Complete after finish(); null if there is none.
    virtual const StoredCloud* cloud() const = 0;
    /// Label of the poses that carry the cloud, whose frame is its own; empty: those of the run's trajectory.
    virtual std::string carried_by() const { return {}; }
};

}  // namespace loopline
