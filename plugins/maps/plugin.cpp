#include <mrpt/core/initializer.h>

#include "maps/grid_module.h"
#include "maps/points_module.h"
#include "maps/simple_map_module.h"

LOOPLINE_PLUGIN();

MRPT_INITIALIZER(register_loopline_maps) {
    mrpt::rtti::registerClass(CLASS_ID(loopline::GridMapBuilder));
    mrpt::rtti::registerClass(CLASS_ID(loopline::PointsMapBuilder));
    mrpt::rtti::registerClass(CLASS_ID(loopline::SimpleMapBuilder));
}
