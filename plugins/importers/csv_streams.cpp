#include "importers/csv_streams.h"

#include "importers/csv_gnss.h"
#include "importers/csv_imu.h"
#include "importers/csv_landmarks.h"
#include "importers/csv_wheels.h"

namespace loopline::csv {

std::unique_ptr<SensorStream> make_stream(ColumnMap& map, const Section& section, const std::string& path,
                                          const std::string& second_path, std::vector<Problem>& problems) {
    switch (section.kind) {
        case Kind::odometry:
            return std::make_unique<OdometryStream>(map, section, path, problems);
        case Kind::steering:
        case Kind::wheels:
            return std::make_unique<CarStream>(map, section, path, problems);
        case Kind::imu:
            return std::make_unique<ImuStream>(map, section, path, second_path, problems);
        case Kind::gnss:
            return std::make_unique<GnssStream>(map, section, path, problems);
        case Kind::landmarks:
            return std::make_unique<LandmarkStream>(map, section, path, problems);
        case Kind::reference:
            break;
    }
    return nullptr;
}

}  // namespace loopline::csv
