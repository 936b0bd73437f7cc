#include "api/module.h"

LOOPLINE_PLUGIN();
