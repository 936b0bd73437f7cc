#include "gnss/geo_reference.h"

#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>

#include "api/parameters.h"
#include "gnss/limits.h"
#include "gnss/utm.h"

namespace loopline::gnss {
namespace {

std::string trimmed(const std::string& text) {
    const std::size_t begin = text.find_first_not_of(" \t\r");
    if (begin == std::string::npos) return {};
    return text.substr(begin, text.find_last_not_of(" \t\r") - begin + 1);
}

/// The value of a key within its range, which is then taken from the map.
double taken(std::map<std::string, double>& values, const std::string& key, double most,
             const std::string& name) {
    const auto found = values.find(key);
    if (found == values.end()) throw std::runtime_error(name + " has no " + key + "; add it");
    const double value = found->second;
    if (!(std::abs(value) <= most))
        throw std::runtime_error(name + " has a " + key + " beyond " + number_text(most) + "; correct it");
    values.erase(found);
    return value;
}

}  // namespace

GeoReference::GeoReference(const Geodetic& origin, double heading_deg)
    : frame_(origin),
      heading_deg_(heading_deg),
      R_enu_map_(Eigen::AngleAxisd(heading_deg * rad_per_deg, Eigen::Vector3d::UnitZ()).toRotationMatrix()) {}

Pose3 T_between(const GeoReference& to, const GeoReference& from) {
    const auto R_ecef_map = [](const GeoReference& reference) {
        const Geodetic& origin = reference.origin();
        return Eigen::Matrix3d(R_ecef_enu(origin.latitude_deg, origin.longitude_deg) * reference.R_enu_map());
    };
    const Eigen::Matrix3d R_to_from = R_ecef_map(to).transpose() * R_ecef_map(from);
    return {to.p_map_m(from.origin()), Eigen::Quaterniond(R_to_from).normalized()};
}

std::string georeference_text(const GeoReference& reference) {
    const Geodetic& origin = reference.origin();
    std::string text =
        "# The origin of the map on WGS84 (EPSG:4979); the height is above the ellipsoid. The map's z axis "
        "points up, along\n"
        "# the ellipsoid's normal at the origin, its x axis lies in the horizon there: the heading is its "
        "direction, counter-\n"
        "# clockwise from east. Its axes are straight, in metres, so that it is no grid of a projection.\n"
        "latitude_deg = " +
        number_text(origin.latitude_deg) + "\nlongitude_deg = " + number_text(origin.longitude_deg) +
        "\nheight_m = " + number_text(origin.height_m) +
        "\nheading_deg = " + number_text(reference.heading_deg()) + "\n";
    if (const auto utm = to_utm(origin))
        text +=
            "# The same origin on the UTM grid, zone " + std::to_string(utm->zone) +
            (utm->north ? " north" : " south") +
            ", which follows from the above: the convergence is that of grid\n# north, clockwise from true "
            "north, the scale a length on the grid by that on the ellipsoid.\nutm_epsg = " +
            std::to_string(epsg_code(*utm)) + "\nutm_zone = " + std::to_string(utm->zone) +
            "\nutm_easting_m = " + number_text(utm->easting_m) +
            "\nutm_northing_m = " + number_text(utm->northing_m) +
            "\nutm_convergence_deg = " + number_text(utm->convergence_rad / rad_per_deg) +
            "\nutm_scale = " + number_text(utm->scale) + "\n";
    return text;
}

GeoReference georeference_from_text(const std::string& text, const std::string& name) {
    std::map<std::string, double> values;
    std::istringstream lines(text);
    std::string line;
    for (int number = 1; std::getline(lines, line); ++number) {
        line = trimmed(line);
        if (line.empty() || line[0] == '#') continue;
        const std::size_t equals = line.find('=');
        const std::string place = name + ":" + std::to_string(number);
        if (equals == std::string::npos)
            throw std::runtime_error(place + " is no line of a georeference; write key = value");
        const std::string key = trimmed(line.substr(0, equals));
        const auto value = number_from_text(trimmed(line.substr(equals + 1)));
        if (!value) throw std::runtime_error(place + ": " + key + " is not a number; correct it");
        if (!values.emplace(key, *value).second)
            throw std::runtime_error(place + " says " + key + " a second time; remove one of the two");
    }
    Geodetic origin;
    origin.latitude_deg = taken(values, "latitude_deg", 90, name);
    origin.longitude_deg = taken(values, "longitude_deg", 360, name);
    origin.height_m = taken(values, "height_m", most_height_m, name);
    for (const char* derived :
         {"utm_epsg", "utm_zone", "utm_easting_m", "utm_northing_m", "utm_convergence_deg", "utm_scale"})
        values.erase(derived);  // the origin tells them
    const double heading_deg = values.count("heading_deg") > 0 ? taken(values, "heading_deg", 360, name) : 0;
    if (!values.empty())
        throw std::runtime_error(name + " has the key " + values.begin()->first +
                                 ", which a georeference does not know; remove it");
    return {origin, heading_deg};
}

void write_georeference(const std::string& file, const GeoReference& reference) {
    std::ofstream stream(file, std::ios::binary);
    stream << georeference_text(reference);
    stream.close();
    if (!stream) throw std::runtime_error("can't write " + file + "; give a folder that can be written");
}

GeoReference read_georeference(const std::string& file) {
    std::ifstream stream(file, std::ios::binary);
    std::ostringstream text;
    text << stream.rdbuf();
    if (!stream) throw std::runtime_error("can't read " + file + "; give a file with a georeference");
    return georeference_from_text(text.str(), file);
}

}  // namespace loopline::gnss
