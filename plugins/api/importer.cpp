#include "api/importer.h"

#include <mrpt/core/initializer.h>
#include <mrpt/rtti/CObject.h>

namespace loopline {
IMPLEMENTS_VIRTUAL_MRPT_OBJECT(Importer, Configurable, loopline)

MRPT_INITIALIZER(register_loopline_importer) {
    mrpt::rtti::registerClass(CLASS_ID(Importer));
}
}  // namespace loopline
