#include <mrpt/core/initializer.h>

#include "simulation/simulator_module.h"

LOOPLINE_PLUGIN();

MRPT_INITIALIZER(register_loopline_simulation) {
    mrpt::rtti::registerClass(CLASS_ID(loopline::WorldSimulator));
}
