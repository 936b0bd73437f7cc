#include <mrpt/core/initializer.h>

#include "grid_slam/grid_localisation_module.h"
#include "grid_slam/grid_slam_module.h"

LOOPLINE_PLUGIN();

MRPT_INITIALIZER(register_loopline_grid_slam) {
    mrpt::rtti::registerClass(CLASS_ID(loopline::GridSlamModule));
    mrpt::rtti::registerClass(CLASS_ID(loopline::GridLocalisationModule));
}
