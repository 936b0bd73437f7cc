#include "grid_slam/grid_localisation_module.h"

#include <algorithm>
#include <cstdio>
#include <stdexcept>

#include "grid_slam/map_file.h"

namespace loopline {
IMPLEMENTS_MRPT_OBJECT(GridLocalisationModule, Module, loopline)

using namespace grid_slam;

namespace {

std::string decimals(double value, int digits) {
    char text[64];
    std::snprintf(text, sizeof text, "%.*f", digits, value);
    return text;
}

}  // namespace

ModuleInfo GridLocalisationModule::info() const {
    ModuleInfo info{"grid_localisation",
                    "Finds the path of a planar laser in a finished grid map, which it leaves as it is.",
                    {"CObservation2DRangeScan"},
                    {},
                    {"CObservationRobotPose"}};
    scans_.add_needs(info);
    return info;
}

std::string GridLocalisationModule::check() const {
    if (map_path_.empty())
        return "map names no map; name a run directory that holds one, or the YAML file of one";
    return {};
}

std::string GridLocalisationModule::check_input_files() const {
    MapServerMap map;
    std::string problem;
    read_map(map_path_, map, problem);
    return problem;
}

std::vector<std::string> GridLocalisationModule::input_files() const {
    MapServerMap map;
    std::string problem;
    const auto yaml = yaml_of_map(map_path_, problem);
    if (!problem.empty() || !read_map_server_map(yaml, map, problem)) return {};
    return {yaml.string(), map.image.string()};
}

void GridLocalisationModule::start(const RunContext& context) {
    trajectory_.keep_in(context.scratch_folder);
    MapServerMap map;
    std::string problem;
    if (!read_map(map_path_, map, problem)) throw std::runtime_error(problem);
    settings_.start_given = start_ == Start::given;
    fit_surfaces_to_noise(settings_.frame, settings_.forward.refinement.sigma_m);
    const double reach_m =
        refinement_on(std::max(cell_m_, map.resolution_m), settings_.forward.refinement).reach_m;
    map_ = std::make_unique<FrozenMap>(map, cell_m_, reach_m);
    localisation_ = std::make_unique<GridLocalisation>(settings_, *map_);
    scans_.start(false);
    scans_.move(localisation_->start());
}

void GridLocalisationModule::process(const StreamItem& item, Publisher& publisher) {
    scans_.take(item, [&](const NavigatedScans::Scan& scan) {
        estimate(scan, publisher);
        return true;
    });
}

void GridLocalisationModule::drain(Publisher& publisher) {
    scans_.drain([&](const NavigatedScans::Scan& scan) { estimate(scan, publisher); });
}

void GridLocalisationModule::estimate(const NavigatedScans::Scan& scan, Publisher& publisher) {
    const PlanarScan* beams = scans_.beams(scan);
    if (beams == nullptr) return;
    const Prediction prediction = scans_.predict(scan);
    const LocalisedScan localised = localisation_->add(*beams, prediction, scans_.sweep(prediction));
    if (localised.T_new_old) scans_.move(*localised.T_new_old);
    scans_.update(scan, localised.match);
    online_.push_back({scan.sequence, scan.stamp_ns, localised.T_map_base});
    if (!localised.known) return;
    const auto published = pose_observation(published_label, localised.T_map_base, localised.covariance);
    published->timestamp = scan.observation->timestamp;
    publisher.publish(published, scan.sequence);
}

void GridLocalisationModule::lay_out_trajectory() {
    if (!localisation_->ever_known()) return;
    const auto& poses = localisation_->poses();
    const auto& covariances = localisation_->covariances();
    for (std::size_t k = 0; k < online_.size(); ++k)
        trajectory_.append_revised(online_[k].sequence, online_[k].stamp_ns, Pose3(online_[k].T_map_base),
                                   Pose3(poses[k]), PoseCovariance::planar(covariances[k]));
    trajectory_.finish_revision();
    trajectory_.set_known_from(localisation_->known_from());
}

double GridLocalisationModule::since_first_s(std::size_t scan) const {
    return seconds_between(online_.front().stamp_ns, online_[scan].stamp_ns);
}

void GridLocalisationModule::report_start(Results& results) const {
    auto& metrics = results.metrics;
    metrics["localised"] = localisation_->ever_known();
    if (!localisation_->ever_known()) return;
    metrics["localised_after_s"] = since_first_s(localisation_->known_from());
    metrics["localised_after_m"] = localisation_->known_after_m();
}

void GridLocalisationModule::report_lost(Results& results) const {
    std::int64_t times = 0, scans = 0;
    double way_m = 0;
    for (const LostStretch& stretch : localisation_->lost()) {
        scans += static_cast<std::int64_t>(stretch.end_scan - stretch.first_scan);
        if (stretch.first_scan == 0) continue;  // no start yet, which is not being lost
        ++times;
        way_m += stretch.way_m;
        results.warnings.push_back(
            "the scans stopped fitting the map " + decimals(since_first_s(stretch.first_scan), 1) +
            " s after the first one; " +
            (stretch.found ? "the place was found again " : "the place was not found again in ") +
            decimals(stretch.way_m, 1) + (stretch.found ? " m later" : " m, up to the end of the log"));
    }
    results.metrics["times_lost"] = times;
    results.metrics["lost_m"] = way_m;
    results.metrics["scans_without_place"] = scans;
}

/// Of the scans since the place was first known.
double GridLocalisationModule::share_matched() const {
    const std::size_t scans = localisation_->scans() - localisation_->known_from();
    if (!localisation_->ever_known() || scans == 0) return 0;
    return static_cast<double>(localisation_->matched()) / static_cast<double>(scans);
}

/// Whether the result can be kept as one.
void GridLocalisationModule::judge(Results& results) const {
    const StartLook& look = localisation_->search().latest();
    const std::string in_map = "in the map " + map_path_;
    if (!localisation_->ever_known()) {
        results.refused = "the place of the vehicle " + in_map + " never became certain in " +
                          decimals(localisation_->way_m(), 1) + " m of way (" + look.reason +
                          "; best place fits by " + decimals(look.likelihood, 2) + ", another by " +
                          decimals(look.rival, 2) +
                          "); give start = given with start_x_m, start_y_m and start_yaw_deg, or a log that "
                          "goes on to where the building is like no other place";
        return;
    }
    if (share_matched() < min_matched_)
        results.refused =
            "only " + decimals(100 * share_matched(), 0) + " % of the scans fit " + map_path_ +
            "; check that the map is of this place, start_x_m, start_y_m and start_yaw_deg, and "
            "[mount], or start with start = global";
}

void GridLocalisationModule::finish(Results& results) {
    lay_out_trajectory();
    auto& metrics = results.metrics;
    const auto scans = localisation_->scans();
    metrics["scans_matched"] = static_cast<std::int64_t>(localisation_->matched());
    metrics["scans_unmatched"] = static_cast<std::int64_t>(localisation_->unmatched());
    metrics["scans_degenerate"] = static_cast<std::int64_t>(localisation_->degenerate());
    metrics["share_matched"] = share_matched();
    metrics["searches"] = localisation_->searches();
    metrics["map_cell_m"] = map_->cell_m();
    metrics["map_surface_points"] = static_cast<std::int64_t>(map_->surface_points());
    if (scans > 0) {
        report_start(results);
        report_lost(results);
        judge(results);
    }
    scans_.report(metrics);
}

}  // namespace loopline
