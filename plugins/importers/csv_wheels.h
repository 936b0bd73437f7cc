/// Wheels in tables: a pose that somebody added up, or speeds that are added up here, as
/// CObservationOdometry.
#pragma once

#include "importers/car_odometry.h"
#include "importers/csv_streams.h"

namespace loopline::csv {

/// Kind "odometry".
class OdometryStream : public SensorStream {
 public:
    OdometryStream(ColumnMap& map, const Section& section, const std::string& path,
                   std::vector<Problem>& problems);
    bool next(const Clock& clock, Reading& reading) override;

 private:
    int x_, y_, yaw_, q_[4], speed_, speed_left_, turn_rate_;
};

/// Kinds "steering" and "wheels".
class CarStream : public SensorStream {
 public:
    CarStream(ColumnMap& map, const Section& section, const std::string& path,
              std::vector<Problem>& problems);
    bool next(const Clock& clock, Reading& reading) override;
    std::vector<std::string> complaints() const override;

 private:
    /// Nothing where the wheels say what no car can do.
    std::optional<CarVelocity> velocity() const;

    int speed_, steering_, left_, right_;
    CarPath path_;
    std::size_t impossible_ = 0;
};

}  // namespace loopline::csv
