#include "api/module.h"

#include <mrpt/core/initializer.h>
#include <mrpt/rtti/CObject.h>

namespace loopline {
IMPLEMENTS_VIRTUAL_MRPT_OBJECT(Configurable, mrpt::rtti::CObject, loopline)
IMPLEMENTS_VIRTUAL_MRPT_OBJECT(Module, Configurable, loopline)
IMPLEMENTS_VIRTUAL_MRPT_OBJECT(MapBuilder, Configurable, loopline)

MRPT_INITIALIZER(register_loopline_api) {
    mrpt::rtti::registerClass(CLASS_ID(Configurable));
    mrpt::rtti::registerClass(CLASS_ID(Module));
    mrpt::rtti::registerClass(CLASS_ID(MapBuilder));
}
}  // namespace loopline
