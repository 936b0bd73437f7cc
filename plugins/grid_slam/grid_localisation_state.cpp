/// What of module "grid_localisation" goes into a checkpoint, class by class. The map is not part of it: it
/// is one of the run's inputs, which a checkpoint knows by their hashes.
#include "grid_slam/grid_localisation_module.h"
#include "grid_slam/navigation_state.h"

namespace loopline {
namespace grid_slam {

template <class Archive>
void fields(Archive& archive, StartSearch& search) {
    archive(search.looked_at_m_, search.looks_);
    archive.each(search.sightings_,
                 [](auto& a, auto& s) { a(s.way_m, s.T_local_base, s.T_map_base, s.information); });
    auto& look = search.latest_;
    archive(look.likelihood, look.fit, look.rival, look.T_map_base, look.ambiguous, look.reason);
}

template <class Archive>
void fields(Archive& archive, GridLocalisation& l) {
    archive(l.poses_, l.covariances_, l.known_from_, l.scans_, l.matched_, l.unmatched_, l.degenerate_);
    archive(l.way_m_, l.known_after_m_, l.fitting_, l.since_fitting_, l.fitting_at_m_, l.unfitting_);
    archive.each(l.lost_, [](auto& a, auto& s) { a(s.first_scan, s.end_scan, s.way_m, s.found); });
    bool searching = l.is_searching();
    archive(searching);
    if constexpr (Archive::reading)
        l.local_ = searching ? std::make_unique<GridSlam>(l.local_settings()) : nullptr;
    if (searching) archive(*l.local_);
    archive(l.region_.whole_map, l.region_.T_map_base, l.region_.covariance, l.local_way_m_, l.T_map_local_,
            l.covariance_at_first_, l.search_, l.earlier_looks_);
}

}  // namespace grid_slam

template <class Archive>
void fields(Archive& archive, GridLocalisationModule& m) {
    archive(*m.localisation_, m.scans_);
    archive.each(m.online_, [](auto& a, auto& pose) { a(pose.sequence, pose.stamp_ns, pose.T_map_base); });
}

void GridLocalisationModule::save_state(mrpt::serialization::CArchive& out) const {
    write_state(out, info().name, 1, *this);
}

void GridLocalisationModule::load_state(mrpt::serialization::CArchive& in) {
    read_state(in, info().name, 1, *this);
}

}  // namespace loopline
