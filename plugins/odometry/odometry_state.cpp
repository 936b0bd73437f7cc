/// What of module "odometry" goes into a checkpoint.
#include "api/state_archive.h"
#include "odometry/odometry_module.h"

namespace loopline {
namespace {
constexpr std::uint32_t form_version = 3;
}

template <class Archive>
void fields(Archive& archive, WheelTicks& ticks) {
    archive(ticks.left, ticks.right);
}

template <class Archive>
void fields(Archive& archive, TickUnwrapper& unwrapper) {
    archive(unwrapper.last_);
}

template <class Archive>
void fields(Archive& archive, OdometrySample& sample) {
    archive(sample.stamp_ns, sample.T_odom_base, sample.ticks);
}

template <class Archive>
void fields(Archive& archive, OdometryAtScans& at_scans) {
    archive(at_scans.samples_, at_scans.forgotten_);
    archive.each(at_scans.scans_, [](auto& a, auto& scan) { a(scan.scan, scan.stamp_ns, scan.before); });
}

template <class Archive>
void fields(Archive& archive, Odometry& odometry) {
    auto& o = odometry;
    archive(o.at_scans_, o.label_in_use_, o.unwrap_ticks_, o.last_ticks_, o.T_odom_base_of_ticks_);
    archive.each(o.waiting_,
                 [](auto& a, auto& scan) { a(scan.sequence, scan.stamp_ns, scan.timestamp, scan.is_sweep); });
    archive(o.path_);
    archive(o.samples_, o.ignored_, o.without_ticks_, o.not_finite_, o.scans_, o.by_file_order_,
            o.extrapolated_);
}

void Odometry::save_state(mrpt::serialization::CArchive& out) const {
    write_state(out, "odometry", form_version, *this);
}

void Odometry::load_state(mrpt::serialization::CArchive& in) {
    read_state(in, "odometry", form_version, *this);
}

}  // namespace loopline
