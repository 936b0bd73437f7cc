#include "importers/csv_landmarks.h"

#include "api/pose2.h"

namespace loopline::csv {

LandmarkStream::LandmarkStream(ColumnMap& map, const Section& section, const std::string& path,
                               std::vector<Problem>& problems)
    : SensorStream(map, section, path, problems),
      range_(rows_.slot("range")),
      bearing_(rows_.slot("bearing")),
      diameter_(rows_.slot("diameter")) {}

bool LandmarkStream::next_possible() {
    while (rows_.next()) {
        if (rows_.value(range_) > 0 && rows_.value_or(diameter_, 0) >= 0) return true;
        ++impossible_;
    }
    return false;
}

mrpt::obs::CObservationBearingRange::TMeasurement LandmarkStream::measurement() const {
    mrpt::obs::CObservationBearingRange::TMeasurement seen;
    // Its middle is the same from all sides.
    seen.range = static_cast<float>(rows_.value(range_) + rows_.value_or(diameter_, 0) / 2);
    seen.yaw = static_cast<float>(wrap_to_pi(rows_.value(bearing_)));
    seen.pitch = 0;
    seen.landmarkID = -1;
    return seen;
}

bool LandmarkStream::next(const Clock& clock, Reading& reading) {
    if (!is_ahead_ && !next_possible()) return false;
    auto observation = mrpt::obs::CObservationBearingRange::Create();
    const StampNs time_ns = rows_.time_ns();
    do observation->sensedData.push_back(measurement());
    while ((is_ahead_ = next_possible()) && rows_.time_ns() == time_ns);
    reading.known_ns = clock.utc_ns(time_ns);
    observation->sensorLabel = section_.name;
    observation->timestamp = stamp_to_mrpt(reading.known_ns);
    observation->sensorLocationOnRobot = {section_.x_m,     section_.y_m,       section_.z_m,
                                          section_.yaw_rad, section_.pitch_rad, section_.roll_rad};
    reading.observation = observation;
    return true;
}

std::vector<std::string> LandmarkStream::complaints() const {
    auto sentences = rows_.complaints();
    if (impossible_ > 0)
        sentences.push_back("[" + section_.name + "]: " + std::to_string(impossible_) +
                            (impossible_ == 1
                                 ? " line has a range or a diameter that can't be and is left out"
                                 : " lines have a range or a diameter that can't be and are left out"));
    return sentences;
}

}  // namespace loopline::csv
