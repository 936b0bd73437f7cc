#include <mrpt/core/initializer.h>

#include "importers/carmen_importer.h"
#include "importers/csv_importer.h"
#include "importers/kitti_importer.h"
#include "importers/nmea_importer.h"

LOOPLINE_PLUGIN();

MRPT_INITIALIZER(register_loopline_importers) {
    mrpt::rtti::registerClass(CLASS_ID(loopline::CarmenImporter));
    mrpt::rtti::registerClass(CLASS_ID(loopline::CsvImporter));
    mrpt::rtti::registerClass(CLASS_ID(loopline::KittiImporter));
    mrpt::rtti::registerClass(CLASS_ID(loopline::NmeaImporter));
}
