/// What of module "cloud_localisation" goes into a checkpoint, class by class. The map is not part of it: it
/// is one of the run's inputs, which a checkpoint knows by their hashes.
#include "cloud_localisation/cloud_localisation_module.h"
#include "lidar_mapping/sweep_mapping_state.h"

namespace loopline {
namespace cloud_localisation {

template <class Archive>
void fields(Archive& archive, FixInMap& fix) {
    archive(fix.stamp_ns, fix.p_map_m, fix.has_height, fix.sigma_m, fix.sigma_z_m, fix.p_base_antenna_m);
}

template <class Archive>
void fields(Archive& archive, StartLook& look) {
    archive(look.found, look.state, look.fit, look.rival_fit, look.reason);
}

template <class Archive>
void fields(Archive& archive, CloudLocalisation& l) {
    archive(l.state_, l.latest_ns_, l.unfitting_s_);
    archive.each(l.way_, [](auto& a, auto& pose) { a(pose.middle_ns, pose.T_frame_base, pose.velocity); });
    archive(l.fixes_, l.latest_fix_, l.off_in_a_row_, l.off_since_ns_, l.looked_ns_);
    bool searching = l.is_searching();
    archive(searching);
    if constexpr (Archive::reading)
        l.local_ = searching ? std::make_unique<lidar_mapping::SweepMapping>(l.settings_.sweeps, l.threads_)
                             : nullptr;
    if (searching) archive(*l.local_);
    archive(l.local_sweeps_, l.local_way_m_);
    bool guessed = l.guess_.has_value();
    archive(guessed);
    if constexpr (Archive::reading)
        l.guess_ = guessed ? std::optional(CloudLocalisation::Guess()) : std::nullopt;
    if (guessed)
        archive(l.guess_->T_map_local, l.guess_->sigma_m, l.guess_->sigma_z_m, l.guess_->sigma_yaw_rad);
    archive.each(l.sightings_, [](auto& a, auto& s) { a(s.T_local_base, s.T_map_base); });
    auto& c = l.counts_;
    archive(l.look_, c.sweeps, c.matched, c.unmatched, c.degenerate, c.searched, c.looks, c.starts, c.lost,
            c.fixes_off, c.moved_by_fixes, l.sum_of_fits_);
}

template <class Archive>
void fields(Archive& archive, LocalisedPath& path) {
    archive(path.sweeps_, path.known_from_);
    archive.each(path.lost_, [](auto& a, auto& s) {
        a(s.first_sweep, s.end_sweep, s.first_ns, s.end_ns, s.found, s.lost_at);
    });
}

}  // namespace cloud_localisation

template <class Archive>
void fields(Archive& archive, CloudLocalisationModule& m) {
    archive(*m.localisation_, *m.led_, m.path_, m.fixes_, m.fixes_usable_, m.nearest_fix_m_);
}

void CloudLocalisationModule::save_state(mrpt::serialization::CArchive& out) const {
    write_state(out, info().name, 4, *this);
}

void CloudLocalisationModule::load_state(mrpt::serialization::CArchive& in) {
    read_state(in, info().name, 4, *this);
}

}  // namespace loopline
