#include <mrpt/core/initializer.h>

#include "survey/survey_module.h"

LOOPLINE_PLUGIN();

MRPT_INITIALIZER(register_loopline_survey) {
    mrpt::rtti::registerClass(CLASS_ID(loopline::SurveyMapBuilder));
}
