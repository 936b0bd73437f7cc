#include <mrpt/core/initializer.h>

#include "odometry/odometry_module.h"

LOOPLINE_PLUGIN();

MRPT_INITIALIZER(register_loopline_odometry) {
    mrpt::rtti::registerClass(CLASS_ID(loopline::Odometry));
}
