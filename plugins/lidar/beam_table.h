/// Elevations of the beams of common spinning lidars.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace loopline::lidar {

struct BeamTable {
    std::string model;                     ///< "HDL-64E"
    std::vector<double> elevations_deg{};  ///< beam by beam, up positive
};

/// From the highest to the lowest: VLP-16 (15 to -15 degrees), HDL-32E (10.67 to -30.67), HDL-64E (2 to -8.33
/// in steps of 1/3, then -8.83 to -24.33 in steps of 1/2), by their manuals. None for other numbers.
std::optional<BeamTable> table_of_beams(int beams);

/// A table as the text that CObservationRotatingScan::lidarModel holds, "VLP-16 elevations_deg 15 13 ...",
/// since the class has no place for angles; and back. A bare "VLP-16" or "HDL-32..." is of MRPT's making: its
/// rows are Velodyne's laser numbers, which alternate between low and high. None for other models.
std::string text_of(const BeamTable& table);
std::optional<BeamTable> table_from_text(const std::string& lidar_model);

/// The order of the beams from the highest to the lowest: `order[ring]` is the beam.
std::vector<int> from_high_to_low(const std::vector<double>& elevations);

}  // namespace loopline::lidar
