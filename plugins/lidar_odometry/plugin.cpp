#include <mrpt/core/initializer.h>

#include "lidar_odometry/lidar_odometry_module.h"

LOOPLINE_PLUGIN();

MRPT_INITIALIZER(register_loopline_lidar_odometry) {
    mrpt::rtti::registerClass(CLASS_ID(loopline::LidarOdometryModule));
}
