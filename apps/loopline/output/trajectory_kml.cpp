#include "output/trajectory_kml.h"

#include <array>
#include <cstdio>
#include <ctime>
#include <string>

#include "api/parameters.h"
#include "output/earth_stretches.h"
#include "output/output_file.h"

namespace loopline {
namespace {

std::string heights_text(const EarthFrame& earth) {
    if (earth.geoid_separation_m)
        return "Heights are above the geoid: above the WGS84 ellipsoid, less " +
               number_text(*earth.geoid_separation_m) + " m, the receiver's separation at the origin.";
    return "Heights are above the WGS84 ellipsoid, since the receiver does not say where the geoid is: above "
           "the "
           "sea they are up to 100 m lower or higher.";
}

void add_coordinates(OutputFile& out, const EarthVertex& vertex, double lowered_m, char separator) {
    out.number(vertex.place.longitude_deg).character(separator).number(vertex.place.latitude_deg);
    out.character(separator).number(vertex.place.height_m - lowered_m);
}

void add_lines(OutputFile& out, const EarthStretches& path, double lowered_m) {
    out.text("<Placemark><name>trajectory</name><styleUrl>#path</styleUrl><MultiGeometry>\n");
    for (std::size_t i = 0; i < path.size(); ++i) {
        out.text("<LineString><altitudeMode>absolute</altitudeMode><coordinates>\n");
        path.for_each(i, [&](const EarthVertex& vertex) {
            add_coordinates(out, vertex, lowered_m, ',');
            out.character('\n');
        });
        out.text("</coordinates></LineString>\n");
    }
    out.text("</MultiGeometry></Placemark>\n");
}

void add_track(OutputFile& out, const EarthStretches& path, double lowered_m) {
    out.text("<Placemark><name>trajectory over time</name><styleUrl>#path</styleUrl><gx:Track>");
    out.text("<altitudeMode>absolute</altitudeMode>\n");
    for (std::size_t i = 0; i < path.size(); ++i)
        path.for_each(i, [&](const EarthVertex& vertex) {
            out.text("<when>").text(iso_time_text(vertex.stamp_ns)).text("</when>\n");
        });
    for (std::size_t i = 0; i < path.size(); ++i)
        path.for_each(i, [&](const EarthVertex& vertex) {
            out.text("<gx:coord>");
            add_coordinates(out, vertex, lowered_m, ' ');
            out.text("</gx:coord>\n");
        });
    out.text("</gx:Track></Placemark>\n");
}

}  // namespace

std::string iso_time_text(StampNs stamp_ns) {
    constexpr StampNs ns_in_s = 1'000'000'000;
    const StampNs rest = (stamp_ns % ns_in_s + ns_in_s) % ns_in_s;
    const std::time_t seconds = (stamp_ns - rest) / ns_in_s;
    std::tm date{};
    gmtime_r(&seconds, &date);
    std::array<char, 64> text{};
    std::snprintf(text.data(), text.size(), "%04d-%02d-%02dT%02d:%02d:%02d.%09lldZ", date.tm_year + 1900,
                  date.tm_mon + 1, date.tm_mday, date.tm_hour, date.tm_min, date.tm_sec,
                  static_cast<long long>(rest));
    return text.data();
}

std::size_t write_trajectory_kml(const std::filesystem::path& file, const Trajectory& trajectory,
                                 const EarthFrame& earth) {
    const EarthStretches path(trajectory, gnss::GeoReference(earth), Estimate::latest);
    const double lowered_m = earth.geoid_separation_m.value_or(0);
    OutputFile out(file);
    out.text(
           "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<kml xmlns=\"http://www.opengis.net/kml/2.2\" "
           "xmlns:gx=\"http://www.google.com/kml/ext/2.2\"><Document><name>trajectory</name>\n<description>")
        .text(heights_text(earth))
        .text(
            "</description>\n<Style "
            "id=\"path\"><LineStyle><color>ffb27200</color><width>3</width></LineStyle>"
            "</Style>\n");
    if (path.size() > 0) {
        add_lines(out, path, lowered_m);
        add_track(out, path, lowered_m);
    }
    out.text("</Document></kml>\n");
    out.commit();
    return path.left_out();
}

}  // namespace loopline
