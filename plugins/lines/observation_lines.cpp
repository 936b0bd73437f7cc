#include "lines/observation_lines.h"

#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/serialization/CArchive.h>

#include <cmath>
#include <iomanip>
#include <ostream>
#include <stdexcept>

namespace loopline {

IMPLEMENTS_SERIALIZABLE(CObservationLines, mrpt::obs::CObservation, loopline)

namespace {

/// More than any scan holds: a larger number comes from a damaged file, and must not be allocated.
constexpr std::uint32_t max_segments = 100'000;
constexpr std::uint32_t max_text = 4'096;

void write_text(mrpt::serialization::CArchive& out, const std::string& text) {
    if (text.size() > max_text)
        throw std::runtime_error("CObservationLines: a sensor label is too long to be written");
    out << static_cast<std::uint32_t>(text.size());
    if (!text.empty()) out.WriteBuffer(text.data(), text.size());
}

std::string read_text(mrpt::serialization::CArchive& in) {
    const auto size = in.ReadAs<std::uint32_t>();
    if (size > max_text)
        throw std::runtime_error("CObservationLines: the file is damaged (a label of absurd length)");
    std::string text(size, '\0');
    if (size > 0) in.ReadBuffer(text.data(), size);
    return text;
}

/// (x y z yaw pitch roll) as plain numbers: MRPT's own reader of poses allocates what a damaged file tells it
/// to.
void write_pose(mrpt::serialization::CArchive& out, const mrpt::poses::CPose3D& pose) {
    for (const double value : {pose.x(), pose.y(), pose.z(), pose.yaw(), pose.pitch(), pose.roll()})
        out << value;
}

mrpt::poses::CPose3D read_pose(mrpt::serialization::CArchive& in) {
    double values[6];
    for (double& value : values) {
        in >> value;
        if (!std::isfinite(value))
            throw std::runtime_error(
                "CObservationLines: the file is damaged (a sensor pose that is not finite)");
    }
    return {values[0], values[1], values[2], values[3], values[4], values[5]};
}

void write_segment(mrpt::serialization::CArchive& out, const lines::LineSegment& s) {
    out << s.rho_m << s.alpha_rad << s.covariance(0, 0) << s.covariance(0, 1) << s.covariance(1, 1)
        << s.start_m.x() << s.start_m.y() << s.end_m.x() << s.end_m.y() << s.rms_m
        << static_cast<std::uint32_t>(s.first_beam) << static_cast<std::uint32_t>(s.last_beam)
        << static_cast<std::uint32_t>(s.beam_count);
}

lines::LineSegment read_segment(mrpt::serialization::CArchive& in) {
    lines::LineSegment s;
    double covariance_01;
    std::uint32_t first_beam, last_beam, beam_count;
    in >> s.rho_m >> s.alpha_rad >> s.covariance(0, 0) >> covariance_01 >> s.covariance(1, 1) >>
        s.start_m.x() >> s.start_m.y() >> s.end_m.x() >> s.end_m.y() >> s.rms_m >> first_beam >> last_beam >>
        beam_count;
    s.covariance(0, 1) = s.covariance(1, 0) = covariance_01;
    s.first_beam = first_beam;
    s.last_beam = last_beam;
    s.beam_count = beam_count;
    const bool finite = std::isfinite(s.rho_m) && std::isfinite(s.alpha_rad) && std::isfinite(s.rms_m) &&
                        s.covariance.allFinite() && s.start_m.allFinite() && s.end_m.allFinite();
    if (!finite)
        throw std::runtime_error("CObservationLines: the file is damaged (a line that is not finite)");
    return s;
}

}  // namespace

const lines::LineSegments& CObservationLines::segments() const {
    if (source_ != nullptr) {
        LineSource& source = *source_;
        source_ = nullptr;
        source.extract(*scan_, segments_);
        scan_.reset();
    }
    return segments_;
}

void CObservationLines::set_segments(lines::LineSegments segments) {
    segments_ = std::move(segments);
    source_ = nullptr;
    scan_.reset();
}

void CObservationLines::set_source(LineSource& source,
                                   std::shared_ptr<const mrpt::obs::CObservation2DRangeScan> scan) {
    segments_.clear();
    source_ = &source;
    scan_ = std::move(scan);
}

std::uint8_t CObservationLines::serializeGetVersion() const {
    return 0;
}

void CObservationLines::serializeTo(mrpt::serialization::CArchive& out) const {
    out << timestamp;
    write_text(out, sensorLabel);
    write_text(out, scan_label);
    write_pose(out, sensor_pose);
    out << static_cast<std::uint32_t>(scan_beams) << static_cast<std::uint32_t>(segments().size());
    for (const lines::LineSegment& s : segments()) write_segment(out, s);
}

void CObservationLines::serializeFrom(mrpt::serialization::CArchive& in, std::uint8_t version) {
    if (version != 0) MRPT_THROW_UNKNOWN_SERIALIZATION_VERSION(version);
    in >> timestamp;
    sensorLabel = read_text(in);
    scan_label = read_text(in);
    sensor_pose = read_pose(in);
    scan_beams = in.ReadAs<std::uint32_t>();
    const auto count = in.ReadAs<std::uint32_t>();
    if (count > max_segments)
        throw std::runtime_error("CObservationLines: the file is damaged (" + std::to_string(count) +
                                 " lines in one scan)");
    // One at a time: a damaged count then ends with the file, not with the memory.
    lines::LineSegments read;
    for (std::uint32_t i = 0; i < count; ++i) read.push_back(read_segment(in));
    set_segments(std::move(read));
}

void CObservationLines::getDescriptionAsText(std::ostream& o) const {
    CObservation::getDescriptionAsText(o);
    const auto flags = o.flags();
    const auto precision = o.precision();
    o << "Lines of scan \"" << scan_label << "\" (" << scan_beams << " beams): " << segments().size() << "\n"
      << "Sensor pose on the vehicle: " << sensor_pose << "\n"
      << "  rho [m]  sigma [m]  alpha [deg]  sigma [deg]  length [m]  beams  first  last  rms [m]\n"
      << std::fixed;
    const double deg = 180 / M_PI;
    for (const lines::LineSegment& s : segments())
        o << std::setprecision(3) << std::setw(9) << s.rho_m << std::setprecision(4) << std::setw(11)
          << std::sqrt(s.covariance(0, 0)) << std::setprecision(2) << std::setw(13) << s.alpha_rad * deg
          << std::setprecision(3) << std::setw(13) << std::sqrt(s.covariance(1, 1)) * deg
          << std::setprecision(2) << std::setw(12) << s.length_m() << std::setw(7) << s.beam_count
          << std::setw(7) << s.first_beam << std::setw(6) << s.last_beam << std::setprecision(4)
          << std::setw(9) << s.rms_m << "\n";
    o.flags(flags);
    o.precision(precision);
}

}  // namespace loopline
