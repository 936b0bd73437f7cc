/// What a break between two sweeps must keep.
#include "lidar_mapping/lidar_mapping_module.h"
#include "lidar_mapping/sweep_mapping_state.h"

namespace loopline {

template <class Archive>
void fields(Archive& archive, LidarMappingModule& m) {
    archive(*m.mapping_, *m.led_, m.sweeps_, m.degenerate_, m.between_, m.way_m_, m.upright_due_m_);
}

void LidarMappingModule::save_state(mrpt::serialization::CArchive& out) const {
    write_state(out, info().name, 8, *this);
}

void LidarMappingModule::load_state(mrpt::serialization::CArchive& in) {
    read_state(in, info().name, 8, *this);
}

}  // namespace loopline
