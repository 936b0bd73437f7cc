// The keys of column maps: what each kind of section knows.
#include "importers/csv_map.h"

namespace loopline::csv {
namespace {

using Q = Quantity;

struct DeclaredColumn {
    const char* key;
    Quantity quantity;
    const char* sentence;
    bool of_second_file = false;
};

const DeclaredColumn time_column{"time", Q::time, "Column of the time."};

const std::vector<DeclaredColumn> quaternion{
    {"qw", Q::number, "Orientation as a unit quaternion, real part."},
    {"qx", Q::number, "The same, along x."},
    {"qy", Q::number, "The same, along y."},
    {"qz", Q::number, "The same, along z."}};

std::vector<DeclaredColumn> joined(std::vector<DeclaredColumn> columns,
                                   const std::vector<DeclaredColumn>& more) {
    columns.insert(columns.end(), more.begin(), more.end());
    return columns;
}

std::vector<DeclaredColumn> declared_columns(Kind kind) {
    switch (kind) {
        case Kind::odometry:
            return joined({time_column,
                           {"x", Q::length, "Place in the frame in which the wheels began to count."},
                           {"y", Q::length, "The same."},
                           {"yaw", Q::angle, "Heading there, counter-clockwise; or qw qx qy qz."},
                           {"speed", Q::speed, "Velocity ahead."},
                           {"speed_left", Q::speed, "Velocity to the left."},
                           {"turn_rate", Q::turn_rate, "Counter-clockwise."}},
                          quaternion);
        case Kind::steering:
            return {time_column,
                    {"speed", Q::speed, "Of the wheel with the encoder, or of the vehicle."},
                    {"steering", Q::angle,
                     "Angle of the front wheels, or of the steering wheel; positive to the left."}};
        case Kind::wheels:
            return {time_column,
                    {"left", Q::speed, "Of the left wheel of the axle that is not steered."},
                    {"right", Q::speed, "Of the right one."}};
        case Kind::imu:
            return joined({time_column,
                           {"turn_rate_x", Q::turn_rate, "About the sensor's x axis."},
                           {"turn_rate_y", Q::turn_rate, "About its y axis."},
                           {"turn_rate_z", Q::turn_rate, "About its z axis."},
                           {"acceleration_time", Q::time, "Time in acceleration_file.", true},
                           {"acceleration_x", Q::acceleration,
                            "What the accelerometers read along the sensor's x axis: at rest, +9.8 along the "
                            "one that points up.",
                            true},
                           {"acceleration_y", Q::acceleration, "Along its y axis.", true},
                           {"acceleration_z", Q::acceleration, "Along its z axis.", true}},
                          quaternion);
        case Kind::gnss:
            return {time_column,
                    {"utc", Q::time,
                     "The receiver's own time of the fix, since 1970; then the fix is stamped by it."},
                    {"latitude", Q::angle, "Of the antenna, north is positive."},
                    {"longitude", Q::angle, "East is positive."},
                    {"east", Q::length, "Instead of latitude and longitude: metres from the origin."},
                    {"north", Q::length, "The same."},
                    {"height", Q::length, "Above the ellipsoid; with east and north, above the origin."},
                    {"altitude", Q::length, "Instead: above the sea, to which geoid_separation_m is added."},
                    {"speed", Q::speed, "Over ground."},
                    {"course", Q::angle, "Of the motion, clockwise from north."},
                    {"sigma_east", Q::length, "Standard deviations as the receiver reports them."},
                    {"sigma_north", Q::length, "The same."},
                    {"sigma_up", Q::length, "The same."},
                    {"variance_east", Q::variance, "Instead of these: their squares."},
                    {"variance_north", Q::variance, "The same."},
                    {"variance_up", Q::variance, "The same."},
                    {"quality", Q::number, "What kind of fix it is, in quality_codes."},
                    {"satellites", Q::number, "How many were used."},
                    {"hdop", Q::number, "Horizontal dilution of precision."}};
        case Kind::landmarks:
            return {time_column,
                    {"range", Q::length,
                     "From the sensor to the landmark; to its near side, if a diameter is given."},
                    {"bearing", Q::angle, "Counter-clockwise from the sensor's x axis."},
                    {"diameter", Q::length, "Of the landmark: half of it is added to the range."}};
        case Kind::reference:
            break;
    }
    return joined(
        {time_column,
         {"ecef_x", Q::length, "Earth-centred place of what the reference is of."},
         {"ecef_y", Q::length, "The same."},
         {"ecef_z", Q::length, "The same."},
         {"latitude", Q::angle, "Instead: place on the Earth."},
         {"longitude", Q::angle, "The same."},
         {"height", Q::length, "The same, above the ellipsoid."},
         {"x", Q::length, "Instead: place in a local frame, z up."},
         {"y", Q::length, "The same."},
         {"z", Q::length, "The same; none: 0."},
         {"yaw", Q::angle,
          "Heading, counter-clockwise from the local frame's x axis, or from east; or qw qx qy qz."},
         {"heading", Q::angle, "Instead of yaw: clockwise from north."},
         {"pitch", Q::angle, "Beside yaw or heading: of Rz(yaw) Ry(pitch) Rx(roll)."},
         {"roll", Q::angle, "The same."}},
        quaternion);
}

const char* sentence_of(Kind kind) {
    switch (kind) {
        case Kind::odometry:
            return "A pose that somebody added up from wheels: CObservationOdometry.";
        case Kind::steering:
            return "Speed and steering of a car, added up to a pose of the middle of its rear axle: "
                   "CObservationOdometry.";
        case Kind::wheels:
            return "Speeds of the two wheels of the axle that is not steered, added up to a pose of its "
                   "middle: "
                   "CObservationOdometry.";
        case Kind::imu:
            return "Turn rates and accelerations: CObservationIMU.";
        case Kind::gnss:
            return "Fixes of a receiver: CObservationGPS.";
        case Kind::landmarks:
            return "Landmarks by range and bearing, a line each, those of one time being one scan: "
                   "CObservationBearingRange.";
        case Kind::reference:
            break;
    }
    return "Where the vehicle really was: F.truth.tum beside F.rawlog, and F.truth.csv if its place on the "
           "Earth is "
           "known.";
}

void add_origin(ParameterTable& table, Section& s, const std::string& what) {
    const Range none_or{-180, Section::no_angle_deg};
    table
        .real("origin_latitude_deg", s.origin_latitude_deg, none_or,
              "Where " + what + " begin; 1000: not said.")
        .real("origin_longitude_deg", s.origin_longitude_deg, none_or, "The same.")
        .real("origin_height_m", s.origin_height_m, {-1000, 10000}, "The same, above the ellipsoid.");
}

}  // namespace

const std::vector<std::pair<std::string, Kind>>& kinds() {
    static const std::vector<std::pair<std::string, Kind>> all{
        {"odometry", Kind::odometry},  {"steering", Kind::steering},
        {"wheels", Kind::wheels},      {"imu", Kind::imu},
        {"gnss", Kind::gnss},          {"landmarks", Kind::landmarks},
        {"reference", Kind::reference}};
    return all;
}

void Section::add_columns(ParameterTable& table) {
    columns.clear();
    for (const DeclaredColumn& declared : declared_columns(kind)) {
        columns.push_back({declared.key, declared.quantity, declared.of_second_file, {}, {}});
        table.text(declared.key, columns.back().text, declared.sentence);
    }
}

void Section::add_mount(ParameterTable& table, bool turned) {
    table.real("x_m", x_m, {-1000, 1000}, "Where it is on the vehicle, ahead of its origin.")
        .real("y_m", y_m, {-1000, 1000}, "The same, to the left.")
        .real("z_m", z_m, {-1000, 1000}, "The same, above.");
    if (turned)
        table.angle("yaw_deg", yaw_rad, {-360, 360}, "How it is turned there: Rz(yaw) Ry(pitch) Rx(roll).")
            .angle("pitch_deg", pitch_rad, {-360, 360}, "The same.")
            .angle("roll_deg", roll_rad, {-360, 360}, "The same.");
}

ParameterTable Section::table() {
    ParameterTable table(name, sentence_of(kind));
    table.choice("kind", kind, kinds(), "What the section is of.")
        .text("file", file, "Name of the table, among the inputs or in a folder that is one.");
    add_columns(table);
    table.real("late_s", late_s, {-60, 60}, "How late its times are: taken off them.");
    switch (kind) {
        case Kind::odometry:
            break;
        case Kind::steering:
            table.real("wheel_base_m", car.wheel_base_m, {0, 100}, "From axle to axle.")
                .real("encoder_left_m", car.encoder_left_m, {-10, 10},
                      "Where the wheel with the encoder is, left of the middle of the rear axle; 0: speed is "
                      "that of "
                      "the middle.")
                .real("steering_ratio", steering_ratio, {0.01, 100},
                      "Angle in the table over that of the front wheels; 1: they are the same.")
                .angle("steering_offset_deg", steering_offset_rad, {-180, 180},
                       "What the table says when the car goes straight.");
            break;
        case Kind::wheels:
            table.real("track_width_m", track_width_m, {0, 100}, "From wheel to wheel.");
            break;
        case Kind::imu:
            table.text("acceleration_file", acceleration_file,
                       "Table of the accelerations, if they are in another one; they are interpolated to the "
                       "times of "
                       "the turn rates.");
            add_mount(table, true);
            break;
        case Kind::gnss:
            table.choice(
                "quality_codes", quality_codes, {{"nmea", QualityCodes::nmea}, {"ros", QualityCodes::ros}},
                "Those of NMEA's GGA (4 fixed, 5 float, 2 differential, 1 single, 0 none), or of ROS' "
                "NavSatStatus (-1 none, 0 single, 1 and 2 differential).");
            table.choice("fixes", fixes,
                         {{"single", gnss::FixQuality::single},
                          {"differential", gnss::FixQuality::differential},
                          {"rtk_float", gnss::FixQuality::rtk_float},
                          {"rtk_fixed", gnss::FixQuality::rtk_fixed}},
                         "What kind they are where no column tells.");
            table.real("geoid_separation_m", geoid_separation_m, {-200, 200},
                       "Geoid above the ellipsoid, where altitudes are above the sea.");
            add_origin(table, *this, "east and north");
            add_mount(table, false);
            break;
        case Kind::landmarks:
            add_mount(table, true);
            break;
        case Kind::reference:
            table.boolean("quaternion_is_inverse", quaternion_is_inverse,
                          "It turns from the frame of the place to the vehicle, rather than back.");
            add_origin(table, *this, "x and y");
            table.real("origin_heading_deg", origin_heading_deg, {-360, 360},
                       "Of the local frame's x axis, counter-clockwise from east.");
            add_mount(table, true);
            break;
    }
    return table;
}

std::vector<ParameterTable> AllKinds::tables() {
    sections.clear();
    std::vector<ParameterTable> tables{clock_table(clock)};
    for (const auto& [name, kind] : kinds()) {
        sections.emplace_back("kind = " + name).kind = kind;
        tables.push_back(sections.back().table());
    }
    return tables;
}

ParameterTable clock_table(ClockSettings& clock) {
    return ParameterTable("clock", "How the times of the tables become UTC.")
        .text("utc_from", clock.utc_from,
              "The GNSS section whose column utc tells how late the clock of the tables is; empty: none.")
        .real("latency_s", clock.latency_s, {-10, 10},
              "With utc_from: how late even its quickest fixes come, which no receiver knows.")
        .real("add_s", clock.add_s, {-4e9, 4e9}, "Added to all times of the tables.");
}

}  // namespace loopline::csv
