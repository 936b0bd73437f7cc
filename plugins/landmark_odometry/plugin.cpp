#include <mrpt/core/initializer.h>

#include "landmark_odometry/landmark_map_builder.h"
#include "landmark_odometry/landmark_odometry_module.h"

LOOPLINE_PLUGIN();

MRPT_INITIALIZER(register_loopline_landmark_odometry) {
    mrpt::rtti::registerClass(CLASS_ID(loopline::LandmarkOdometryModule));
    mrpt::rtti::registerClass(CLASS_ID(loopline::LandmarkMapBuilder));
}
