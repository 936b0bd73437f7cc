#include "output/map_files.h"

#include "output/line_map_csv.h"
#include "output/line_map_geojson.h"

namespace loopline {

void write_map_files(const std::filesystem::path& folder, const Results& results, FileList& list) {
    if (results.line_map) {
        list.add("map.lines.csv", write_line_map_csv(folder / "map.lines.csv", *results.line_map), "lines");
        list.add("map.lines.geojson", write_line_map_geojson(folder / "map.lines.geojson", *results.line_map),
                 "lines");
    }
}

}  // namespace loopline
