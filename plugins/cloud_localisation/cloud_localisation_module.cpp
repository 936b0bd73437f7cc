#include "cloud_localisation/cloud_localisation_module.h"

#include <mrpt/obs/CObservationGPS.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "api/observation_class.h"
#include "api/pose_observation.h"
#include "api/sweep_classes.h"
#include "gnss/gps_observation.h"

namespace loopline {
IMPLEMENTS_MRPT_OBJECT(CloudLocalisationModule, Module, loopline)

using namespace cloud_localisation;
using namespace lidar_mapping;

namespace {

std::string decimals(double value, int digits) {
    char text[64];
    std::snprintf(text, sizeof text, "%.*f", digits, value);
    return text;
}

}  // namespace

ModuleInfo CloudLocalisationModule::info() const {
    ModuleInfo info{"cloud_localisation",
                    "Finds the path of a spinning lidar in a finished point cloud, which it leaves as it is; "
                    "the start by itself, from a GNSS receiver's place.",
                    {},
                    sweep_classes(),
                    {"CObservationRobotPose"}};
    (start_ == Start::gnss ? info.needs : info.uses).emplace_back("CObservationGPS");
    led_settings_.use(info);
    return info;
}

std::string CloudLocalisationModule::check() const {
    if (map_path_.empty())
        return "map names no map; name a run directory that holds a cloud, or a PLY, PCD or LAS file of one";
    return {};
}

std::string CloudLocalisationModule::check_input_files() const {
    CloudMapFile map;
    std::string problem;
    if (!open_cloud_map(map_path_, map, problem)) return problem;
    try {
        if (map.path) MapUncertainty known(*map.path);
    } catch (const std::runtime_error& error) {
        return error.what();
    }
    if (start_ == Start::gnss && !map.georeference)
        return "there is no georeference.txt beside " + map.file.string() +
               ", so that a fix does not tell where in the map it is; give start = given with start_x_m, "
               "start_y_m, start_z_m and start_yaw_deg, or the map of a run with module fusion";
    return {};
}

std::vector<std::string> CloudLocalisationModule::input_files() const {
    CloudMapFile map;
    std::string problem;
    if (!open_cloud_map(map_path_, map, problem)) return {};
    std::vector<std::string> files{map.file.string()};
    if (!map.georeference_file.empty()) files.push_back(map.georeference_file.string());
    if (map.path) files.insert(files.end(), {map.path->trajectory.string(), map.path->covariance.string()});
    return files;
}

void CloudLocalisationModule::start(const RunContext& context) {
    trajectory_.keep_in(context.scratch_folder);
    path_.keep_in(context.scratch_folder);
    CloudMapFile map;
    std::string problem;
    if (!open_cloud_map(map_path_, map, problem)) throw std::runtime_error(problem);
    georeference_ = map.georeference;
    settings_.T_map_start.reset();
    if (start_ == Start::given) {
        settings_.T_map_start = Pose3(Pose2{start_x_m_, start_y_m_, start_yaw_rad_});
        settings_.T_map_start->translation_m.z() = start_z_m_;
    }
    {
        WorkerPool workers(context.threads);
        map_ = std::make_unique<FrozenCloud>(*map.points, settings_.sweeps.map, workers);
    }
    localisation_ = std::make_unique<CloudLocalisation>(
        settings_, *map_, context.threads, map.path ? MapUncertainty(*map.path) : MapUncertainty());
    led_ = std::make_unique<LedSweeps>(led_settings_);
}

void CloudLocalisationModule::process(const StreamItem& item, Publisher& publisher) {
    if (const auto* gps = as<mrpt::obs::CObservationGPS>(item.observation.get()))
        return take_fix(*gps, item.stamp_ns);
    led_->take(item, [&](const LedSweeps::Sweep& sweep) { follow(sweep, publisher); });
}

void CloudLocalisationModule::drain(Publisher& publisher) {
    led_->drain([&](const LedSweeps::Sweep& sweep) { follow(sweep, publisher); });
}

void CloudLocalisationModule::take_fix(const mrpt::obs::CObservationGPS& gps, StampNs stamp_ns) {
    if (!georeference_ || (!receiver_.empty() && gps.sensorLabel != receiver_)) return;
    ++fixes_;
    const auto fix = gnss::fix_from_mrpt(gps, stamp_ns);
    if (!fix || !fix->is_usable()) return;
    const gnss::SigmaOfFix sigma = gnss::sigma_of(*fix, fix_noise_);
    const Eigen::Vector3d sigma_m(std::hypot(sigma.white_m.x(), sigma.correlated_m.x()),
                                  std::hypot(sigma.white_m.y(), sigma.correlated_m.y()),
                                  std::hypot(sigma.white_m.z(), sigma.correlated_m.z()));
    gnss::Geodetic antenna = fix->antenna;
    if (!fix->has_height) antenna.height_m = georeference_->origin().height_m;
    FixInMap in_map;
    in_map.stamp_ns = fix->stamp_ns - std::llround(1e9 * latency_s_);
    in_map.p_map_m = georeference_->p_map_m(antenna);
    in_map.has_height = fix->has_height;
    in_map.sigma_m = std::max(sigma_m.x(), sigma_m.y());
    in_map.sigma_z_m = sigma_m.z();
    in_map.p_base_antenna_m = fix->p_base_antenna_m;
    const double off_m = map_->distance_m(in_map.p_map_m);
    nearest_fix_m_ = fixes_usable_ == 0 ? off_m : std::min(nearest_fix_m_, off_m);
    ++fixes_usable_;
    localisation_->take_fix(in_map);
}

void CloudLocalisationModule::follow(const LedSweeps::Sweep& now, Publisher& publisher) {
    const auto given = led_->motion(localisation_->latest_middle_ns(), now.middle_ns());
    const LocalisedSweep localised = localisation_->add(now.scan, given ? &*given : nullptr);
    led_->forget_before(now.middle_ns());
    path_.add(now.sequence, now.stamp_ns, localised);
    if (!localised.known) return;
    publisher.publish(
        pose_observation(published_label, now.timestamp, localised.T_map_base, localised.covariance),
        now.sequence);
}

/// Of the sweeps whose place was known, those that fitted.
double CloudLocalisationModule::share_matched() const {
    const auto& counts = localisation_->counts();
    const std::int64_t followed = counts.matched + counts.unmatched;
    return followed > 0 ? static_cast<double>(counts.matched) / static_cast<double>(followed) : 0;
}

void CloudLocalisationModule::report_start(Results& results) const {
    auto& metrics = results.metrics;
    metrics["localised"] = path_.known_from().has_value();
    if (!path_.known_from()) return;
    metrics["localised_after_s"] = seconds_between(path_.first_ns(), path_.known_from_ns());
}

void CloudLocalisationModule::report_lost(Results& results) const {
    double lost_s = 0;
    for (const LostStretch& stretch : path_.lost()) {
        if (stretch.first_sweep == 0) continue;  // no start yet, which is not being lost
        const double seconds = seconds_between(stretch.first_ns, stretch.end_ns);
        lost_s += seconds;
        results.warnings.push_back(
            "the place in the map was lost " +
            decimals(seconds_between(path_.first_ns(), stretch.first_ns), 1) + " s after the first sweep; " +
            (stretch.found ? "it was found again " : "it was not found again in ") + decimals(seconds, 1) +
            (stretch.found ? " s later" : " s, up to the end of the log"));
    }
    results.metrics["times_lost"] = localisation_->counts().lost;
    results.metrics["lost_s"] = lost_s;
    results.metrics["scans_without_place"] = static_cast<std::int64_t>(path_.without_place());
}

/// Whether the result can be kept as one.
void CloudLocalisationModule::judge(Results& results) const {
    const StartLook& look = localisation_->latest_look();
    if (path_.known_from()) {
        if (share_matched() < min_matched_)
            results.refused = "only " + decimals(100 * share_matched(), 0) + " % of the sweeps fit " +
                              map_path_ + "; check that the map is of this place, and [mount]";
        return;
    }
    const std::string never = "the place of the vehicle in the map " + map_path_ + " never became certain: ";
    if (start_ == Start::gnss && fixes_usable_ == 0)
        results.refused = never + "none of " + std::to_string(fixes_) +
                          " fixes has a place; give start = given with start_x_m, start_y_m, start_z_m and "
                          "start_yaw_deg, or look at the receiver with `loopline check`";
    else if (start_ == Start::gnss && nearest_fix_m_ > settings_.start.range_m)
        results.refused = never + "the fixes are " + decimals(nearest_fix_m_, 0) +
                          " m outside of it, or farther; give the map of this place";
    else
        results.refused =
            never + look.reason + " (the best fits by " + decimals(look.fit, 2) + ", another by " +
            decimals(look.rival_fit, 2) +
            "); check that the map is of this place, and [mount], or give start = given with start_x_m, "
            "start_y_m, start_z_m and start_yaw_deg";
}

void CloudLocalisationModule::finish(Results& results) {
    path_.lay_out(trajectory_);
    if (georeference_) {
        const gnss::Geodetic& origin = georeference_->origin();
        results.earth = EarthFrame{origin.latitude_deg, origin.longitude_deg, origin.height_m,
                                   georeference_->heading_deg()};
    }
    const auto& counts = localisation_->counts();
    auto& metrics = results.metrics;
    metrics["scans_matched"] = counts.matched;
    metrics["scans_unmatched"] = counts.unmatched;
    metrics["scans_degenerate"] = counts.degenerate;
    metrics["share_matched"] = share_matched();
    metrics["fit_mean"] = localisation_->mean_fit();
    metrics["searches"] = counts.looks;
    metrics["starts"] = counts.starts;
    metrics["map_points"] = static_cast<std::int64_t>(map_->points());
    metrics["map_cells"] = static_cast<std::int64_t>(map_->surfaces().cells());
    metrics["map_area_m2"] = map_->area_m2();
    if (led_->unusable() > 0) metrics["scans_unusable"] = led_->unusable();
    if (fixes_ > 0) {
        metrics["fixes_off_the_path"] = counts.fixes_off;
        metrics["moved_by_fixes"] = counts.moved_by_fixes;
    }
    if (led_->odometry_never_came())
        results.warnings.push_back("[cloud_localisation] odometry = " + led_settings_.odometry.label +
                                   ", but no pose with that label came; the velocity was taken to go on");
    if (path_.sweeps() == 0) {
        results.refused =
            "the log has no sweep that module cloud_localisation can use; see `loopline check` "
            "for what it has, and [cloud_localisation] sensors";
        return;
    }
    report_start(results);
    report_lost(results);
    judge(results);
}

}  // namespace loopline
