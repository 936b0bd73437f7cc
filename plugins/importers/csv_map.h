/// Column maps: what the columns of somebody's tables are, as an .ini with a section for each sensor.
#pragma once

#include <deque>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "api/parameters.h"
#include "api/pose3.h"
#include "config/ini_file.h"
#include "gnss/gnss_fix.h"
#include "importers/car_odometry.h"
#include "importers/csv_units.h"

namespace loopline::csv {

enum class Kind { odometry, steering, wheels, imu, gnss, landmarks, reference };

/// All kinds with their names in a map.
const std::vector<std::pair<std::string, Kind>>& kinds();

/// A key of a map whose value is a column.
struct ColumnKey {
    std::string key;
    Quantity quantity;
    bool of_second_file = false;
    std::string text;     ///< as it stands in the map; empty: there is none
    ColumnChoice choice;  ///< of that text
};

/// One section: a sensor, or the reference.
struct Section {
    explicit Section(std::string label) : name(std::move(label)) {}
    Section(const Section&) = delete;
    Section& operator=(const Section&) = delete;

    /// The keys of the section's kind, bound to what follows.
    ParameterTable table();
    /// The key of a column; null if the map does not give one.
    const ColumnKey* column(const std::string& key) const;
    bool has(const std::string& key) const { return column(key) != nullptr; }
    /// Pose of the sensor, or of what the reference is of, on the vehicle.
    Pose3 T_base_sensor() const;
    /// All keys, or none, of a group.
    bool has_all(const std::vector<std::string>& keys) const;
    bool has_any(const std::vector<std::string>& keys) const;

    std::string name;  ///< in the map, and the label of the observations
    Kind kind = Kind::odometry;
    std::string file, acceleration_file;
    std::deque<ColumnKey> columns;
    double late_s = 0;
    double x_m = 0, y_m = 0, z_m = 0, yaw_rad = 0, pitch_rad = 0, roll_rad = 0;

    SteeredCar car{0, 0};
    double steering_ratio = 1, steering_offset_rad = 0;
    double track_width_m = 0;

    enum class QualityCodes { nmea, ros } quality_codes = QualityCodes::nmea;
    gnss::FixQuality fixes = gnss::FixQuality::single;
    double geoid_separation_m = 0;

    double origin_latitude_deg = no_angle_deg, origin_longitude_deg = no_angle_deg, origin_height_m = 0,
           origin_heading_deg = 0;
    bool quaternion_is_inverse = false;

    static constexpr double no_angle_deg = 1000;  ///< of an origin that is not given
    bool has_origin() const { return origin_latitude_deg != no_angle_deg; }
    gnss::Geodetic origin() const { return {origin_latitude_deg, origin_longitude_deg, origin_height_m}; }

 private:
    void add_columns(ParameterTable& table);
    void add_mount(ParameterTable& table, bool turned);
};

/// Times of the files and those of the rawlog.
struct ClockSettings {
    std::string utc_from;  ///< name of the section whose column "utc" tells; empty: no section does
    double latency_s = 0, add_s = 0;
};

struct ColumnMap {
    std::string path;
    ClockSettings clock;
    std::vector<std::unique_ptr<Section>> sections;  ///< in the order of the map
    IniFile ini;                                     ///< for the places of complaints

    /// Where a key stands; the section's head if it does not.
    Origin origin(const Section& section, const std::string& key);
};

/// Reads and checks a map. Throws ConfigurationError with all that is wrong, a sentence each with file:line.
ColumnMap read_column_map(const std::string& path);

/// Keys that are missing, say the same twice or do not go together.
void check_section(ColumnMap& map, const Section& section, std::vector<Problem>& problems);

/// The path of a map: `name` itself, or NAME.ini of those that come with the program. Throws
/// CommandError(exit_configuration) if it is neither.
std::string path_of_column_map(const std::string& name);

/// The keys of [clock].
ParameterTable clock_table(ClockSettings& clock);
/// A section of each kind, for the pages that describe them.
struct AllKinds {
    /// Bound to this; of [clock] and of each kind.
    std::vector<ParameterTable> tables();

    ClockSettings clock;
    std::deque<Section> sections;
};

}  // namespace loopline::csv
