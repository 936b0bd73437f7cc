#include <mrpt/core/initializer.h>

#include "cloud_localisation/cloud_localisation_module.h"

LOOPLINE_PLUGIN();

MRPT_INITIALIZER(register_loopline_cloud_localisation) {
    mrpt::rtti::registerClass(CLASS_ID(loopline::CloudLocalisationModule));
}
