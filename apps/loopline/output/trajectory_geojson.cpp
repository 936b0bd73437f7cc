#include "output/trajectory_geojson.h"

#include <cmath>

#include "output/earth_stretches.h"
#include "output/output_file.h"

namespace loopline {
namespace {

/// Elements of a JSON list with commas between them.
class JsonList {
 public:
    explicit JsonList(OutputFile& out) : out_(out) { out_.character('['); }
    OutputFile& next() {
        if (!first_) out_.character(',');
        first_ = false;
        return out_;
    }
    void end() { out_.character(']'); }

 private:
    OutputFile& out_;
    bool first_ = true;
};

void add_position(OutputFile& out, const gnss::Geodetic& place, bool has_height = true) {
    out.character('[').number(place.longitude_deg).character(',').number(place.latitude_deg);
    if (has_height) out.character(',').number(place.height_m);
    out.character(']');
}

/// `"name":[...]` with a number for each vertex, null where there is none.
template <class ValueOf>
void add_numbers(OutputFile& out, const char* name, const EarthStretches& path, std::size_t stretch,
                 const ValueOf& value_of) {
    out.text(",\n\"").text(name).text("\":");
    JsonList list(out);
    path.for_each(stretch, [&](const EarthVertex& vertex) {
        const double value = value_of(vertex);
        if (std::isfinite(value))
            list.next().number(value);
        else
            list.next().text("null");
    });
    list.end();
}

void add_path(OutputFile& out, const EarthStretches& path, std::size_t stretch, const char* kind,
              bool has_sigmas) {
    // A line has two positions or more.
    const bool is_line = path.vertices(stretch) > 1;
    out.text(",\n{\"type\":\"Feature\",\"geometry\":{\"type\":")
        .text(is_line ? "\"LineString\"" : "\"Point\"")
        .text(",\"coordinates\":");
    if (is_line) {
        JsonList list(out);
        path.for_each(stretch, [&](const EarthVertex& vertex) { add_position(list.next(), vertex.place); });
        list.end();
    } else {
        path.for_each(stretch, [&](const EarthVertex& vertex) { add_position(out, vertex.place); });
    }
    out.text("},\n\"properties\":{\"kind\":\"").text(kind).text("\",\"part\":").count(stretch + 1);
    out.text(",\"parts\":").count(path.size()).text(",\n\"stamps_s\":");
    JsonList stamps(out);
    path.for_each(stretch, [&](const EarthVertex& vertex) { stamps.next().seconds(vertex.stamp_ns); });
    stamps.end();
    if (has_sigmas) {
        const char* names[] = {"sigma_east_m", "sigma_north_m", "sigma_up_m"};
        for (int axis = 0; axis < 3; ++axis)
            add_numbers(out, names[axis], path, stretch,
                        [axis](const EarthVertex& vertex) { return vertex.sigma_enu_m[axis]; });
        add_numbers(out, "sigma_heading_rad", path, stretch,
                    [](const EarthVertex& vertex) { return vertex.sigma_heading_rad; });
    }
    out.text("}}");
}

void add_fixes(OutputFile& out, const PlacedFixes& fixes, std::uint64_t fate,
               const gnss::GeoReference& reference) {
    const SetAside<PlacedFix>& list = *fixes.list;
    const auto for_each_of_fate = [&](const auto& use) {
        list.for_each(0, list.size(), [&](const PlacedFix& fix) {
            if (fix.fate == fate && std::isfinite(fix.p_map_m[0]) && std::isfinite(fix.p_map_m[1])) use(fix);
        });
    };
    std::size_t count = 0;
    for_each_of_fate([&count](const PlacedFix&) { ++count; });
    if (count == 0) return;
    out.text(",\n{\"type\":\"Feature\",\"geometry\":{\"type\":\"MultiPoint\",\"coordinates\":");
    JsonList positions(out);
    for_each_of_fate([&](const PlacedFix& fix) {
        const bool has_height = std::isfinite(fix.p_map_m[2]);
        add_position(positions.next(),
                     reference.geodetic({fix.p_map_m[0], fix.p_map_m[1], has_height ? fix.p_map_m[2] : 0}),
                     has_height);
    });
    positions.end();
    out.text("},\n\"properties\":{\"kind\":\"fixes\",\"fate\":\"").text(fixes.fates[fate]);
    out.text("\",\n\"stamps_s\":");
    JsonList stamps(out);
    for_each_of_fate([&](const PlacedFix& fix) { stamps.next().seconds(fix.stamp_ns); });
    stamps.end();
    out.text("}}");
}

}  // namespace

std::size_t write_trajectory_geojson(const std::filesystem::path& file, const Trajectory& trajectory,
                                     const EarthFrame& earth, const PlacedFixes& fixes) {
    const gnss::GeoReference reference(earth);
    const EarthStretches path(trajectory, reference, Estimate::latest),
        online(trajectory, reference, Estimate::online);
    OutputFile out(file);
    out.text("{\"type\":\"FeatureCollection\",\n\"name\":\"trajectory\",\n");
    out.text("\"heights_note\":\"metres above the WGS84 ellipsoid\",\n\"features\":[\n");
    // The first feature is where the frame's origin lies, so that all others have a comma in front.
    out.text("{\"type\":\"Feature\",\"geometry\":{\"type\":\"Point\",\"coordinates\":");
    add_position(out, {earth.latitude_deg, gnss::wrapped_longitude_deg(earth.longitude_deg), earth.height_m});
    out.text("},\n\"properties\":{\"kind\":\"origin\"}}");
    for (std::size_t i = 0; i < path.size(); ++i) add_path(out, path, i, "trajectory", true);
    for (std::size_t i = 0; i < online.size(); ++i) add_path(out, online, i, "trajectory_online", false);
    for (std::size_t fate = 0; !fixes.empty() && fate < fixes.fates.size(); ++fate)
        add_fixes(out, fixes, fate, reference);
    out.text("\n]}\n");
    out.commit();
    return path.left_out();
}

}  // namespace loopline
