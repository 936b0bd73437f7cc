#include "output/line_map_geojson.h"

#include <algorithm>
#include <cmath>

#include "output/line_map_csv.h"
#include "output/output_file.h"

namespace loopline {
namespace {

void write_feature(OutputFile& out, const MapLine& line) {
    const auto sigma = [&line](int i) { return std::sqrt(std::max(0.0, line.covariance(i, i))); };
    out.text(R"({"type":"Feature","id":)").count(line.id);
    out.text(R"(,"geometry":{"type":"LineString","coordinates":[[)");
    out.number(line.start_m.x()).text(",").number(line.start_m.y()).text("],[");
    out.number(line.end_m.x()).text(",").number(line.end_m.y());
    out.text(R"(]]},"properties":{"id":)").count(line.id);
    out.text(R"(,"rho_m":)").number(line.rho_m).text(R"(,"alpha_rad":)").number(line.alpha_rad);
    out.text(R"(,"sigma_rho_m":)").number(sigma(0)).text(R"(,"sigma_alpha_rad":)").number(sigma(1));
    out.text(R"(,"observations":)").integer(line.observations).text("}}");
}

}  // namespace

std::size_t write_line_map_geojson(const std::filesystem::path& file, const LineMap& lines) {
    OutputFile out(file);
    out.text("{\"type\":\"FeatureCollection\",\n\"name\":\"map.lines\",\n");
    out.text(
        R"("coordinates_note":"metres in the local map frame of the run (x forward and y left of the first pose), )");
    out.text("not longitude and latitude\",\n\"features\":[");
    std::size_t left_out = 0;
    bool first = true;
    for (const auto& line : lines) {
        if (!is_finite(line)) {
            ++left_out;
            continue;
        }
        out.text(first ? "\n" : ",\n");
        write_feature(out, line);
        first = false;
    }
    out.text("\n]}\n");
    out.commit();
    return left_out;
}

}  // namespace loopline
