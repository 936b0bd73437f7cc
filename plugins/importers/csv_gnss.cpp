#include "importers/csv_gnss.h"

#include <algorithm>
#include <cmath>

#include "gnss/gps_observation.h"

namespace loopline::csv {
namespace {

StampNs quickest(std::vector<StampNs> offsets_ns) {
    if (offsets_ns.empty()) return 0;
    const auto place = offsets_ns.begin() + static_cast<std::ptrdiff_t>((offsets_ns.size() - 1) * 19 / 20);
    std::nth_element(offsets_ns.begin(), place, offsets_ns.end());
    return *place;
}

}  // namespace

ClockOffset clock_offset(Rows& rows) {
    std::vector<StampNs> offsets_ns;
    while (rows.next()) offsets_ns.push_back(rows.utc_ns() - rows.time_ns());
    const auto middle = offsets_ns.begin() + static_cast<std::ptrdiff_t>(offsets_ns.size() / 2);
    return {quickest(offsets_ns),
            std::abs(seconds_between(quickest({offsets_ns.begin(), middle}),
                                     quickest({middle, offsets_ns.end()}))),
            offsets_ns.size()};
}

GnssStream::GnssStream(ColumnMap& map, const Section& section, const std::string& path,
                       std::vector<Problem>& problems)
    : SensorStream(map, section, path, problems),
      latitude_(rows_.slot("latitude")),
      longitude_(rows_.slot("longitude")),
      east_(rows_.slot("east")),
      north_(rows_.slot("north")),
      height_(rows_.slot("height")),
      altitude_(rows_.slot("altitude")),
      speed_(rows_.slot("speed")),
      course_(rows_.slot("course")),
      sigma_{rows_.slot("sigma_east"), rows_.slot("sigma_north"), rows_.slot("sigma_up")},
      variance_{rows_.slot("variance_east"), rows_.slot("variance_north"), rows_.slot("variance_up")},
      quality_(rows_.slot("quality")),
      satellites_(rows_.slot("satellites")),
      hdop_(rows_.slot("hdop")) {
    if (section.has_origin()) frame_.emplace(section.origin());
}

gnss::FixQuality GnssStream::quality() const {
    using gnss::FixQuality;
    if (quality_ == Rows::none) return section_.fixes;
    const long code = std::lround(std::clamp(rows_.value(quality_), -100.0, 100.0));
    if (section_.quality_codes == Section::QualityCodes::nmea)
        return gnss::fix_quality(static_cast<int>(code));
    return code < 0 || code > 2 ? FixQuality::invalid
           : code == 0          ? FixQuality::single
                                : FixQuality::differential;
}

bool GnssStream::take_place(gnss::GnssFix& fix) const {
    fix.has_height = height_ != Rows::none || altitude_ != Rows::none;
    if (frame_) {
        fix.antenna = frame_->geodetic({rows_.value(east_), rows_.value(north_), rows_.value_or(height_, 0)});
        return true;
    }
    fix.antenna.latitude_deg = rows_.value(latitude_) / gnss::rad_per_deg;
    fix.antenna.longitude_deg = rows_.value(longitude_) / gnss::rad_per_deg;
    if (altitude_ != Rows::none) {
        fix.geoid_separation_m = section_.geoid_separation_m;
        fix.antenna.height_m = rows_.value(altitude_) + fix.geoid_separation_m;
    } else {
        fix.antenna.height_m = rows_.value_or(height_, 0);
    }
    return std::abs(fix.antenna.latitude_deg) <= 90 && std::abs(fix.antenna.longitude_deg) <= 360;
}

std::optional<gnss::GnssFix> GnssStream::fix() const {
    gnss::GnssFix fix;
    fix.quality = quality();
    fix.has_position = fix.quality != gnss::FixQuality::invalid;
    if (fix.has_position && !take_place(fix)) return std::nullopt;
    fix.p_base_antenna_m = {section_.x_m, section_.y_m, section_.z_m};
    if (speed_ != Rows::none) {
        fix.speed_mps = rows_.value(speed_);
        fix.course_rad = gnss::east_angle_rad(rows_.value(course_) / gnss::rad_per_deg);
    }
    const int* const deviations = sigma_[0] != Rows::none ? sigma_ : variance_;
    if (deviations[0] != Rows::none) {
        Eigen::Vector3d sigma_m(rows_.value(deviations[0]), rows_.value(deviations[1]),
                                rows_.value(deviations[2]));
        if (deviations == variance_) sigma_m = sigma_m.cwiseMax(0).cwiseSqrt();
        if ((sigma_m.array() > 0).all()) fix.sigma_enu_m = sigma_m;  // receivers write 0 for "not known"
    }
    if (satellites_ != Rows::none)
        fix.satellites = static_cast<int>(std::lround(std::clamp(rows_.value(satellites_), 0.0, 999.0)));
    if (hdop_ != Rows::none && rows_.value(hdop_) > 0) fix.hdop = rows_.value(hdop_);
    return fix;
}

bool GnssStream::next(const Clock& clock, Reading& reading) {
    while (rows_.next()) {
        auto fix = this->fix();
        if (!fix) {
            ++impossible_;
            continue;
        }
        reading.known_ns = fix->stamp_ns = clock.utc_ns(rows_.time_ns());
        if (rows_.has_utc()) {
            fix->stamp_ns = rows_.utc_ns();
            reading.known_ns = std::max(reading.known_ns, fix->stamp_ns);
            fix->received_ns = reading.known_ns;
        }
        auto observation = gnss::gps_observation(*fix, section_.name);
        observation->has_satellite_timestamp = rows_.has_utc();
        reading.observation = observation;
        return true;
    }
    return false;
}

std::vector<std::string> GnssStream::complaints() const {
    auto sentences = rows_.complaints();
    if (impossible_ > 0)
        sentences.push_back(
            "[" + section_.name + "]: " + std::to_string(impossible_) +
            " fixes are nowhere on the Earth and are left out; look at the units of latitude and "
            "longitude");
    return sentences;
}

}  // namespace loopline::csv
