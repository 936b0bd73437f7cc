#include <mrpt/core/initializer.h>

#include "line_slam/line_slam_module.h"

LOOPLINE_PLUGIN();

MRPT_INITIALIZER(register_loopline_line_slam) {
    mrpt::rtti::registerClass(CLASS_ID(loopline::LineSlam));
}
