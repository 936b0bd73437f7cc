#include <mrpt/core/initializer.h>

#include "api/module.h"
#include "lines/line_extraction.h"
#include "lines/observation_lines.h"

LOOPLINE_PLUGIN();

MRPT_INITIALIZER(register_loopline_lines) {
    mrpt::rtti::registerClass(CLASS_ID(loopline::CObservationLines));
    mrpt::rtti::registerClass(CLASS_ID(loopline::LineExtraction));
}
