#include <mrpt/core/initializer.h>

#include "lidar_mapping/lidar_mapping_module.h"

LOOPLINE_PLUGIN();

MRPT_INITIALIZER(register_loopline_lidar_mapping) {
    mrpt::rtti::registerClass(CLASS_ID(loopline::LidarMappingModule));
}
