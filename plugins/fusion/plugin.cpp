#include <mrpt/core/initializer.h>

#include "fusion/fusion_module.h"

LOOPLINE_PLUGIN();

MRPT_INITIALIZER(register_loopline_fusion) {
    mrpt::rtti::registerClass(CLASS_ID(loopline::FusionModule));
}
