#include "importers/csv_imu.h"

#include <mrpt/obs/CObservationIMU.h>

namespace loopline::csv {

ImuStream::ImuStream(ColumnMap& map, const Section& section, const std::string& path,
                     const std::string& second_path, std::vector<Problem>& problems)
    : SensorStream(map, section, path, problems),
      turn_rate_{rows_.slot("turn_rate_x"), rows_.slot("turn_rate_y"), rows_.slot("turn_rate_z")},
      q_{rows_.slot("qw"), rows_.slot("qx"), rows_.slot("qy"), rows_.slot("qz")} {
    if (!second_path.empty()) second_ = std::make_unique<Rows>(map, section, second_path, true, problems);
    const Rows& with = second_ ? *second_ : rows_;
    for (int i = 0; i < 3; ++i) acceleration_[i] = with.slot(std::string("acceleration_") + "xyz"[i]);
}

bool ImuStream::next_sample() {
    before_ = after_;
    after_.reset();
    if (!second_->next()) return false;
    after_ = Sample{second_->time_ns(),
                    {second_->value(acceleration_[0]), second_->value(acceleration_[1]),
                     second_->value(acceleration_[2])}};
    return true;
}

std::optional<Eigen::Vector3d> ImuStream::acceleration_at(StampNs time_ns) {
    constexpr double longest_step_s = 0.2;
    if (!before_ && !after_) next_sample();
    while (after_ && after_->time_ns <= time_ns && next_sample()) {
    }
    if (before_ && before_->time_ns == time_ns) return before_->mps2;
    if (!before_ || !after_ || time_ns < before_->time_ns) return std::nullopt;
    const double step_s = seconds_between(before_->time_ns, after_->time_ns);
    if (step_s > longest_step_s) return std::nullopt;
    return before_->mps2 +
           seconds_between(before_->time_ns, time_ns) / step_s * (after_->mps2 - before_->mps2);
}

bool ImuStream::next(const Clock& clock, Reading& reading) {
    while (rows_.next()) {
        std::optional<Eigen::Vector3d> acceleration_mps2;
        if (second_)
            acceleration_mps2 = acceleration_at(rows_.time_ns());
        else
            acceleration_mps2 = {rows_.value(acceleration_[0]), rows_.value(acceleration_[1]),
                                 rows_.value(acceleration_[2])};
        if (!acceleration_mps2) {
            ++without_acceleration_;
            continue;
        }
        using namespace mrpt::obs;
        auto imu = CObservationIMU::Create();
        imu->sensorLabel = section_.name;
        reading.known_ns = clock.utc_ns(rows_.time_ns());
        imu->timestamp = stamp_to_mrpt(reading.known_ns);
        imu->sensorPose = mrpt::poses::CPose3D(section_.x_m, section_.y_m, section_.z_m, section_.yaw_rad,
                                               section_.pitch_rad, section_.roll_rad);
        imu->set(IMU_WX, rows_.value(turn_rate_[0]));
        imu->set(IMU_WY, rows_.value(turn_rate_[1]));
        imu->set(IMU_WZ, rows_.value(turn_rate_[2]));
        imu->set(IMU_X_ACC, acceleration_mps2->x());
        imu->set(IMU_Y_ACC, acceleration_mps2->y());
        imu->set(IMU_Z_ACC, acceleration_mps2->z());
        if (q_[0] != Rows::none) {
            imu->set(IMU_ORI_QUAT_W, rows_.value(q_[0]));
            imu->set(IMU_ORI_QUAT_X, rows_.value(q_[1]));
            imu->set(IMU_ORI_QUAT_Y, rows_.value(q_[2]));
            imu->set(IMU_ORI_QUAT_Z, rows_.value(q_[3]));
        }
        reading.observation = imu;
        return true;
    }
    return false;
}

std::vector<std::string> ImuStream::complaints() const {
    auto sentences = rows_.complaints();
    if (second_)
        for (const auto& sentence : second_->complaints()) sentences.push_back(sentence);
    if (without_acceleration_ > 0)
        sentences.push_back("[" + section_.name + "]: " + std::to_string(without_acceleration_) +
                            " lines have no accelerations around their time in " +
                            section_.acceleration_file + " and are left out");
    return sentences;
}

}  // namespace loopline::csv
