#include <mrpt/core/initializer.h>

#include "cloud_map/cloud_map_module.h"
#include "cloud_map/final_cloud_map.h"

LOOPLINE_PLUGIN();

MRPT_INITIALIZER(register_loopline_cloud_map) {
    mrpt::rtti::registerClass(CLASS_ID(loopline::CloudMapModule));
    mrpt::rtti::registerClass(CLASS_ID(loopline::FinalCloudMapBuilder));
}
