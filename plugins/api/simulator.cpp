#include "api/simulator.h"

#include <mrpt/core/initializer.h>
#include <mrpt/rtti/CObject.h>

namespace loopline {
IMPLEMENTS_VIRTUAL_MRPT_OBJECT(Simulator, Configurable, loopline)

MRPT_INITIALIZER(register_loopline_simulator) {
    mrpt::rtti::registerClass(CLASS_ID(Simulator));
}
}  // namespace loopline
