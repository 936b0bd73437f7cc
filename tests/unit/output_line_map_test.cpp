/// Round trips of the line map files.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "commands/command.h"
#include "output/line_map_csv.h"
#include "output/line_map_geojson.h"
#include "output_test_support.h"

using namespace loopline;
using output_test::content;
using output_test::Folder;

namespace {

LineMap random_lines(std::size_t size, std::uint64_t seed) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    LineMap lines;
    for (std::size_t i = 0; i < size; ++i) {
        MapLine line;
        line.id = i == 0 ? std::numeric_limits<std::uint64_t>::max() : 7 * i;
        line.rho_m = 10 * normal(random);
        line.alpha_rad = wrap_to_pi(normal(random));
        const Eigen::Matrix2d root = Eigen::Matrix2d::NullaryExpr([&] { return 0.1 * normal(random); });
        line.covariance = root * root.transpose();
        line.covariance(1, 0) = line.covariance(0, 1);
        line.start_m = {normal(random), normal(random)};
        line.end_m = {normal(random), normal(random)};
        line.observations = static_cast<int>(i);
        lines.push_back(line);
    }
    return lines;
}

void expect_equal(const MapLine& a, const MapLine& b) {
    EXPECT_EQ(a.id, b.id);
    EXPECT_EQ(a.rho_m, b.rho_m);
    EXPECT_EQ(a.alpha_rad, b.alpha_rad);
    EXPECT_EQ(a.covariance, b.covariance);
    EXPECT_EQ(a.start_m, b.start_m);
    EXPECT_EQ(a.end_m, b.end_m);
    EXPECT_EQ(a.observations, b.observations);
}

}  // namespace

TEST(OutputLineMap, csv_reads_back_to_the_same_bits) {
    const Folder folder;
    const LineMap lines = random_lines(20, 1);
    EXPECT_EQ(write_line_map_csv(folder / "l.csv", lines), 0u);
    const LineMap again = read_line_map_csv(folder / "l.csv");
    ASSERT_EQ(again.size(), lines.size());
    for (std::size_t i = 0; i < lines.size(); ++i) expect_equal(lines[i], again[i]);
}

TEST(OutputLineMap, geojson_is_json_with_the_same_values_and_claims_no_coordinate_system) {
    const Folder folder;
    const LineMap lines = random_lines(20, 2);
    EXPECT_EQ(write_line_map_geojson(folder / "l.geojson", lines), 0u);
    const auto json = nlohmann::json::parse(content(folder / "l.geojson"));
    EXPECT_EQ(json["type"], "FeatureCollection");
    EXPECT_FALSE(json.contains("crs"));
    EXPECT_NE(json["coordinates_note"].get<std::string>().find("metres"), std::string::npos);
    ASSERT_EQ(json["features"].size(), lines.size());
    for (std::size_t i = 0; i < lines.size(); ++i) {
        const auto& feature = json["features"][i];
        EXPECT_EQ(feature["type"], "Feature");
        EXPECT_EQ(feature["geometry"]["type"], "LineString");
        MapLine line = lines[i];
        const auto& ends = feature["geometry"]["coordinates"];
        line.start_m = {ends[0][0].get<double>(), ends[0][1].get<double>()};
        line.end_m = {ends[1][0].get<double>(), ends[1][1].get<double>()};
        const auto& properties = feature["properties"];
        line.id = properties["id"].get<std::uint64_t>();
        line.rho_m = properties["rho_m"].get<double>();
        line.alpha_rad = properties["alpha_rad"].get<double>();
        line.observations = properties["observations"].get<int>();
        expect_equal(lines[i], line);
        EXPECT_EQ(properties["sigma_rho_m"].get<double>(), std::sqrt(lines[i].covariance(0, 0)));
        EXPECT_EQ(properties["sigma_alpha_rad"].get<double>(), std::sqrt(lines[i].covariance(1, 1)));
    }
}

TEST(OutputLineMap, lines_that_are_not_finite_are_left_out_and_counted) {
    const Folder folder;
    LineMap lines = random_lines(5, 3);
    lines[1].rho_m = std::numeric_limits<double>::quiet_NaN();
    lines[3].covariance(1, 1) = std::numeric_limits<double>::infinity();
    EXPECT_EQ(write_line_map_csv(folder / "l.csv", lines), 2u);
    EXPECT_EQ(write_line_map_geojson(folder / "l.geojson", lines), 2u);
    EXPECT_EQ(read_line_map_csv(folder / "l.csv").size(), 3u);
    EXPECT_EQ(nlohmann::json::parse(content(folder / "l.geojson"))["features"].size(), 3u);
}

TEST(OutputLineMap, empty_map_makes_valid_files) {
    const Folder folder;
    write_line_map_csv(folder / "l.csv", {});
    write_line_map_geojson(folder / "l.geojson", {});
    EXPECT_TRUE(read_line_map_csv(folder / "l.csv").empty());
    EXPECT_TRUE(nlohmann::json::parse(content(folder / "l.geojson"))["features"].empty());
}

TEST(OutputLineMap, csv_reader_names_file_and_line) {
    const Folder folder;
    write_line_map_csv(folder / "l.csv", random_lines(2, 4));
    const std::string good = content(folder / "l.csv");
    for (const auto& [text, where] : {std::pair<std::string, std::string>{"a,b\n1,2\n", "bad.csv:1:"},
                                      {good + "1,2,3\n", "bad.csv:4:"},
                                      {good + "1,nan,0,0,0,0,0,0,0,0,1\n", "bad.csv:4:"},
                                      {"", "bad.csv"}}) {
        std::ofstream(folder / "bad.csv") << text;
        try {
            read_line_map_csv(folder / "bad.csv");
            ADD_FAILURE() << text;
        } catch (const CommandError& e) {
            EXPECT_EQ(e.code(), exit_input_data);
            EXPECT_NE(std::string(e.what()).find(where), std::string::npos) << e.what();
        }
    }
}
