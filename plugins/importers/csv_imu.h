/// IMUs in tables, their accelerations in the same or in another one, as CObservationIMU.
#pragma once

#include "importers/csv_streams.h"

namespace loopline::csv {

/// Kind "imu".
class ImuStream : public SensorStream {
 public:
    ImuStream(ColumnMap& map, const Section& section, const std::string& path, const std::string& second_path,
              std::vector<Problem>& problems);
    bool next(const Clock& clock, Reading& reading) override;
    std::vector<std::string> complaints() const override;

 private:
    struct Sample {
        StampNs time_ns;
        Eigen::Vector3d mps2;
    };
    bool next_sample();
    /// Between the two accelerations around a time; nothing if they are too far apart.
    std::optional<Eigen::Vector3d> acceleration_at(StampNs time_ns);

    int turn_rate_[3], acceleration_[3], q_[4];
    std::unique_ptr<Rows> second_;
    std::optional<Sample> before_, after_;
    std::size_t without_acceleration_ = 0;
};

}  // namespace loopline::csv
