#include "pipeline/known_objects.h"

#include <mrpt/maps/CMetricMap.h>
#include <mrpt/math/CMatrixFixed.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string_view>

namespace loopline {
namespace {

using mrpt::obs::CObservation2DRangeScan;
using mrpt::obs::CObservationOdometry;

constexpr std::uint8_t end_flag = 0x88;

/// What stands in front of an object: the length of its class name with the highest bit set, the name, the
/// version.
template <std::size_t size>
constexpr std::size_t head_bytes(const char (&)[size]) {
    return size + 1;
}

class Bytes {
 public:
    Bytes(const unsigned char* at, std::size_t size) : begin_(at), at_(at), end_(at + size) {}

    bool has(std::size_t size) const { return static_cast<std::size_t>(end_ - at_) >= size; }
    std::size_t passed() const { return static_cast<std::size_t>(at_ - begin_); }
    const unsigned char* take(std::size_t size) {
        const unsigned char* const taken = at_;
        at_ += size;
        return taken;
    }
    template <class Number>
    Number next() {
        Number value;
        std::memcpy(&value, take(sizeof(value)), sizeof(value));
        return value;
    }
    template <std::size_t size>
    bool next_is_head(const char (&class_name)[size], std::uint8_t version) {
        const unsigned char* const head = take(head_bytes(class_name));
        return head[0] == (0x80 | (size - 1)) && std::memcmp(head + 1, class_name, size - 1) == 0 &&
               head[size] == version;
    }
    bool next_is_end_flag() { return next<std::uint8_t>() == end_flag; }
    /// False if it is neither true nor false, as in damaged bytes.
    bool next_flag(bool& flag) {
        const auto byte = next<std::uint8_t>();
        flag = byte == 1;
        return byte <= 1;
    }

 private:
    const unsigned char* begin_;
    const unsigned char* at_;
    const unsigned char* end_;
};

constexpr char scan_class[] = "mrpt::obs::CObservation2DRangeScan";
constexpr char odometry_class[] = "mrpt::obs::CObservationOdometry";
constexpr char spatial_pose_class[] = "mrpt::poses::CPose3D";
constexpr char planar_pose_class[] = "mrpt::poses::CPose2D";
constexpr std::uint8_t scan_version = 7, odometry_version = 2, spatial_pose_version = 3,
                       planar_pose_version = 1;

constexpr std::size_t spatial_pose_bytes = head_bytes(spatial_pose_class) + 12 * sizeof(double) + 1;
constexpr std::size_t planar_pose_bytes = head_bytes(planar_pose_class) + 3 * sizeof(double) + 1;

bool same_bytes(const void* a, const void* b, std::size_t size) {
    return std::memcmp(a, b, size) == 0;
}

/// Translation, then the rotation matrix row by row. A pose that stands in the object already, from the scan
/// that it held before, keeps its angles, which cost more than all the rest.
bool read_pose(Bytes& bytes, mrpt::poses::CPose3D& pose) {
    if (!bytes.next_is_head(spatial_pose_class, spatial_pose_version)) return false;
    double numbers[12];
    std::memcpy(numbers, bytes.take(sizeof(numbers)), sizeof(numbers));
    mrpt::math::CMatrixDouble33 rotation(mrpt::math::UNINITIALIZED_MATRIX);
    std::memcpy(rotation.data(), numbers + 3, 9 * sizeof(double));
    if (!same_bytes(pose.getRotationMatrix().data(), rotation.data(), 9 * sizeof(double)))
        pose.setRotationMatrix(rotation);
    std::memcpy(pose.m_coords.data(), numbers, 3 * sizeof(double));
    return bytes.next_is_end_flag();
}

bool read_pose(Bytes& bytes, mrpt::poses::CPose2D& pose) {
    if (!bytes.next_is_head(planar_pose_class, planar_pose_version)) return false;
    pose.m_coords[0] = bytes.next<double>();
    pose.m_coords[1] = bytes.next<double>();
    pose.phi(bytes.next<double>());
    return bytes.next_is_end_flag();
}

mrpt::system::TTimeStamp next_time(Bytes& bytes) {
    return mrpt::Clock::time_point(mrpt::Clock::duration(bytes.next<std::int64_t>()));
}

/// Ranges and whether they are valid; false if a validity is no flag.
bool read_ranges(CObservation2DRangeScan& scan, std::size_t beams, const unsigned char* ranges,
                 const unsigned char* validity, std::vector<float>& ranges_m) {
    unsigned char all = 0;
    for (std::size_t i = 0; i < beams; ++i) all |= validity[i];
    if (all > 1) return false;
    ranges_m.resize(beams);
    std::memcpy(ranges_m.data(), ranges, beams * sizeof(float));  // in the file they stand anywhere
    scan.loadFromVectors(beams, ranges_m.data(), reinterpret_cast<const char*>(validity));
    return true;
}

constexpr std::size_t scan_front_bytes = 4 + 1 + 4 + spatial_pose_bytes + 4;  // aperture .. number of beams
constexpr std::size_t beam_bytes = 4 + 1;
constexpr std::size_t scan_middle_bytes = 4 + 8 + 4 + 4;  // standard error .. length of the label
constexpr std::size_t scan_back_bytes = 8 + 1 + 1;        // pitch, whether there are intensities, end flag
constexpr std::uint32_t most_beams = 1 << 15, longest_label = 1 << 12;

/// Behind the head. 0: not as MRPT writes it, or with intensities; else the size of the object, which is
/// `scan` if it was there in full.
std::size_t read_scan(Bytes bytes, CObservation2DRangeScan& scan, std::vector<float>& ranges_m) {
    if (!bytes.has(scan_front_bytes)) return bytes.passed() + scan_front_bytes;
    scan.aperture = bytes.next<float>();
    if (!bytes.next_flag(scan.rightToLeft)) return 0;
    scan.maxRange = bytes.next<float>();
    if (!read_pose(bytes, scan.sensorPose)) return 0;
    const auto beams = bytes.next<std::uint32_t>();
    if (beams == 0 || beams > most_beams) return 0;

    const std::size_t to_label = beams * beam_bytes + scan_middle_bytes;
    if (!bytes.has(to_label)) return bytes.passed() + to_label;
    const unsigned char* const ranges = bytes.take(beams * sizeof(float));
    const unsigned char* const validity = bytes.take(beams);
    if (!read_ranges(scan, beams, ranges, validity, ranges_m)) return 0;
    scan.stdError = bytes.next<float>();
    scan.timestamp = next_time(bytes);
    scan.beamAperture = bytes.next<float>();
    const auto label = bytes.next<std::uint32_t>();
    if (label > longest_label) return 0;

    if (!bytes.has(label + scan_back_bytes)) return bytes.passed() + label + scan_back_bytes;
    scan.sensorLabel.assign(reinterpret_cast<const char*>(bytes.take(label)), label);
    scan.deltaPitch = bytes.next<double>();
    bool has_intensity = false;
    if (!bytes.next_flag(has_intensity) || has_intensity || !bytes.next_is_end_flag()) return 0;
    scan.setScanHasIntensity(false);
    return bytes.passed();
}

constexpr std::size_t odometry_front_bytes = planar_pose_bytes + 4;  // pose, length of the label
constexpr std::size_t odometry_middle_bytes = 8 + 1;                 // time, whether there are ticks
constexpr std::size_t tick_bytes = 4 + 4, velocity_bytes = 3 * sizeof(double);

std::size_t read_odometry(Bytes bytes, CObservationOdometry& odometry) {
    if (!bytes.has(odometry_front_bytes)) return bytes.passed() + odometry_front_bytes;
    if (!read_pose(bytes, odometry.odometry)) return 0;
    const auto label = bytes.next<std::uint32_t>();
    if (label > longest_label) return 0;
    // What follows a flag is there if the flag says so: as many bytes are asked for as are sure to come.
    const std::size_t to_ticks = label + odometry_middle_bytes;
    if (!bytes.has(to_ticks + 2)) return bytes.passed() + to_ticks + 2;

    odometry.sensorLabel.assign(reinterpret_cast<const char*>(bytes.take(label)), label);
    odometry.timestamp = next_time(bytes);
    if (!bytes.next_flag(odometry.hasEncodersInfo)) return 0;
    const std::size_t to_velocities = (odometry.hasEncodersInfo ? tick_bytes : 0) + 1;
    if (!bytes.has(to_velocities + 1)) return bytes.passed() + to_velocities + 1;
    odometry.encoderLeftTicks = odometry.hasEncodersInfo ? bytes.next<std::int32_t>() : 0;
    odometry.encoderRightTicks = odometry.hasEncodersInfo ? bytes.next<std::int32_t>() : 0;
    if (!bytes.next_flag(odometry.hasVelocities)) return 0;
    const std::size_t to_end = (odometry.hasVelocities ? velocity_bytes : 0) + 1;
    if (!bytes.has(to_end)) return bytes.passed() + to_end;
    odometry.velocityLocal = {};
    if (odometry.hasVelocities)
        for (double* part :
             {&odometry.velocityLocal.vx, &odometry.velocityLocal.vy, &odometry.velocityLocal.omega})
            *part = bytes.next<double>();
    return bytes.next_is_end_flag() ? bytes.passed() : 0;
}

}  // namespace

CObservation2DRangeScan::Ptr KnownObjects::free_scan() {
    auto scan = scans_.take();
    // Points that somebody drew from the scan that it held before stay with it.
    const bool has_points = scan->getAuxPointsMap<mrpt::maps::CMetricMap>() != nullptr;
    return has_points ? CObservation2DRangeScan::Create() : scan;
}

KnownObjects::Reading KnownObjects::read(const unsigned char* bytes, std::size_t size) {
    constexpr std::size_t longest_head = std::max(head_bytes(scan_class), head_bytes(odometry_class));
    if (size < longest_head) return {nullptr, longest_head};
    const auto reading = [size](mrpt::obs::CObservation::Ptr object, std::size_t object_bytes) {
        const bool whole = object_bytes > 0 && object_bytes <= size;
        return Reading{whole ? std::move(object) : nullptr, object_bytes};
    };
    Bytes as_scan(bytes, size), as_odometry(bytes, size);
    if (as_scan.next_is_head(scan_class, scan_version)) {
        const auto scan = free_scan();
        return reading(scan, read_scan(as_scan, *scan, ranges_m_));
    }
    if (as_odometry.next_is_head(odometry_class, odometry_version)) {
        const auto odometry = odometry_.take();
        return reading(odometry, read_odometry(as_odometry, *odometry));
    }
    return {};
}

}  // namespace loopline
