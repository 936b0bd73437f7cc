/// What a break between two sweeps must keep.
#include "lidar_mapping/lidar_mapping_module.h"
#include "lidar_mapping/sweep_mapping_state.h"

namespace loopline {

template <class Archive>
void fields(Archive& archive, LidarMappingModule& m) {
    archive(*m.mapping_, m.sweeps_, m.unusable_, m.degenerate_, *m.odometry_, m.between_, m.waits_);
    if (m.waits_) archive(m.now_.sequence, m.now_.stamp_ns, m.now_.timestamp, m.now_.scan);
}

void LidarMappingModule::save_state(mrpt::serialization::CArchive& out) const {
    write_state(out, info().name, 4, *this);
}

void LidarMappingModule::load_state(mrpt::serialization::CArchive& in) {
    read_state(in, info().name, 4, *this);
}

}  // namespace loopline
