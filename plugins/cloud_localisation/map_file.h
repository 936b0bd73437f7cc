/// The finished cloud that a key of the .ini names.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "cloud_localisation/map_uncertainty.h"
#include "gnss/geo_reference.h"
#include "point_files/point_file.h"

namespace loopline::cloud_localisation {

struct CloudMapFile {
    std::filesystem::path file;
    std::filesystem::path georeference_file;  ///< empty: there is none beside it
    std::shared_ptr<const PointFile> points;  ///< null where only names are asked for
    std::optional<gnss::GeoReference> georeference;
    /// Of the run that placed it on the Earth, if they lie beside it: trajectory.tum and covariance.csv.
    std::optional<PathFiles> path;
};

/// The file of a run directory's cloud, or the one that is named. With `problem`, a sentence, if there is
/// none.
std::filesystem::path file_of_cloud(const std::filesystem::path& named, std::string& problem);

/// Opens it, and sees that a vehicle can be localised in it; else false with `problem`, a sentence.
bool open_cloud_map(const std::filesystem::path& named, CloudMapFile& map, std::string& problem);

}  // namespace loopline::cloud_localisation
