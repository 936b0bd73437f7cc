#include "evaluate/surveyed_truth.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "evaluate/text_rows.h"

namespace loopline {
namespace {

void take_row(const TextRow& row, const std::string& kind, SurveyedTruth& truth) {
    const auto need = [&row, &kind](std::size_t columns, const char* form) {
        if (row.size() < columns) row.fail("a " + kind + " needs " + form);
    };
    if (kind == "point") {
        need(4, "point,number,x_m,y_m");
        const double number = row.number(1);
        if (number != std::floor(number) || std::abs(number) > 1e9)
            row.fail("the number of a point is a whole one");
        truth.points.push_back({static_cast<int>(number), {row.number(2), row.number(3)}});
    } else if (kind == "wall") {
        need(8, "wall,number,x_m,y_m,x2_m,y2_m,bottom_m,top_m");
        truth.walls.push_back({{row.number(2), row.number(3)},
                               {row.number(4), row.number(5)},
                               std::min(row.number(6), row.number(7)),
                               std::max(row.number(6), row.number(7))});
    } else if (kind == "level") {
        need(3, "level,number,z_m");
        truth.levels_m.push_back(row.number(2));
    } else if (kind == "georeference") {
        need(6, "georeference,0,latitude_deg,longitude_deg,height_m,heading_deg");
        truth.earth = EarthFrame{row.number(2), row.number(3), row.number(4), row.number(5)};
    }
}

}  // namespace

SurveyedTruth read_surveyed_truth(const std::filesystem::path& file, const std::string& what) {
    SurveyedTruth truth;
    for_each_csv_row(file, what, [&truth](const TextRow& row) { take_row(row, row.word(0), truth); });
    return truth;
}

}  // namespace loopline
