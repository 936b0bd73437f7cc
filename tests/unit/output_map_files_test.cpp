/// Round trips of grids, points and keyframes, by readers that are not ours.
#include <gtest/gtest.h>
#include <mrpt/io/CFileGZInputStream.h>
#include <mrpt/maps/COccupancyGridMap2D.h>
#include <mrpt/maps/CSimpleMap.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/poses/CPose3DPDFGaussian.h>
#include <mrpt/serialization/CArchive.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <map>

#include "api/map_server_map.h"
#include "commands/command.h"
#include "output/map_files.h"
#include "output/map_server_grid.h"
#include "output_test_support.h"

using namespace loopline;
using mrpt::maps::COccupancyGridMap2D;
using mrpt::maps::CSimpleMap;
using mrpt::maps::CSimplePointsMap;
using output_test::content;
using output_test::Folder;
using output_test::split;

namespace {

/// 37 x 23 cells with every value that a cell can have, unsymmetrical, away from the origin.
COccupancyGridMap2D::Ptr example_grid() {
    auto grid = COccupancyGridMap2D::Create(-3.35f, -1.5f, 4.2f, 5.35f, 0.05f);
    for (unsigned y = 0; y < grid->getSizeY(); ++y)
        for (unsigned x = 0; x < grid->getSizeX(); ++x)
            grid->getRow(static_cast<int>(y))[x] =
                static_cast<COccupancyGridMap2D::cellType>(static_cast<int>((x * 7 + y * 31) % 256) - 128);
    return grid;
}

CSimplePointsMap::Ptr example_points() {
    auto points = CSimplePointsMap::Create();
    std::mt19937_64 random(1);
    std::normal_distribution<float> normal(0, 100);
    for (int i = 0; i < 1000; ++i) {
        const float x = normal(random), y = normal(random), z = normal(random);
        points->insertPoint(x, y, z);
    }
    return points;
}

CSimpleMap::Ptr example_simple_map() {
    auto map = CSimpleMap::Create();
    for (int i = 0; i < 5; ++i) {
        auto pose = mrpt::poses::CPose3DPDFGaussian::Create();
        pose->mean = mrpt::poses::CPose3D(i, -i, 0.1 * i, 0.2 * i, 0.01 * i, 0);
        for (int k = 0; k < 6; ++k) pose->cov(k, k) = 0.01 * (i + 1) * (k + 1);
        auto frame = mrpt::obs::CSensoryFrame::Create();
        auto scan = mrpt::obs::CObservation2DRangeScan::Create();
        const float ranges[] = {1.0f, 2.0f, 3.5f + static_cast<float>(i)};
        const char valid[] = {1, 0, 1};
        scan->loadFromVectors(3, ranges, valid);
        scan->sensorLabel = "LASER";
        frame->insert(scan);
        map->insert(pose, frame);
    }
    return map;
}

Results results_with(const std::vector<NamedMap>& maps) {
    Results results;
    results.maps = maps;
    return results;
}

struct MapServerMap {
    int width = 0, height = 0;
    double resolution = 0, origin_x = 0, origin_y = 0;
    std::vector<int> data;  ///< as in nav_msgs/OccupancyGrid: row 0 is the lowest y; 100, 0, -1
};

/// ROS map_server's rules, written down anew: SDL hands it the picture from the top row, it turns it round;
/// thresholds are strict; "trinary" makes everything between them -1.
MapServerMap read_as_map_server_does(const std::filesystem::path& yaml) {
    std::map<std::string, std::string> keys;
    std::ifstream in(yaml);
    for (std::string line; std::getline(in, line);) {
        const auto colon = line.find(": ");
        EXPECT_NE(colon, std::string::npos) << line;
        keys[line.substr(0, colon)] = line.substr(colon + 2);
    }
    EXPECT_EQ(keys.at("mode"), "trinary");
    const bool negate = std::stoi(keys.at("negate")) != 0;
    const double occupied_thresh = std::stod(keys.at("occupied_thresh")),
                 free_thresh = std::stod(keys.at("free_thresh"));

    MapServerMap map;
    map.resolution = std::stod(keys.at("resolution"));
    const auto origin = split(keys.at("origin").substr(1), ',');
    map.origin_x = std::stod(origin[0]);
    map.origin_y = std::stod(origin[1]);
    EXPECT_EQ(std::stod(origin[2]), 0);

    std::ifstream picture(yaml.parent_path() / keys.at("image"), std::ios::binary);
    std::string magic;
    int most = 0;
    picture >> magic >> map.width >> map.height >> most;
    EXPECT_EQ(magic, "P5");
    EXPECT_EQ(most, 255);
    picture.get();
    std::string pixels(static_cast<std::size_t>(map.width * map.height), '\0');
    picture.read(pixels.data(), static_cast<std::streamsize>(pixels.size()));
    EXPECT_TRUE(picture.good());
    EXPECT_EQ(picture.get(), EOF);
    for (int row = 0; row < map.height; ++row)
        for (int column = 0; column < map.width; ++column) {
            const int from_top = map.height - 1 - row;
            int p =
                static_cast<unsigned char>(pixels[static_cast<std::size_t>(from_top * map.width + column)]);
            if (negate) p = 255 - p;
            const double occupied = (255 - p) / 255.0;
            map.data.push_back(occupied > occupied_thresh ? 100 : occupied < free_thresh ? 0 : -1);
        }
    return map;
}

std::vector<std::array<float, 3>> floats_after(const std::string& text, const std::string& header_end) {
    const auto at = text.find(header_end);
    EXPECT_NE(at, std::string::npos);
    const std::string body = text.substr(at + header_end.size());
    EXPECT_EQ(body.size() % 12, 0u);
    std::vector<std::array<float, 3>> points(body.size() / 12);
    std::memcpy(points.data(), body.data(), body.size());
    return points;
}

void expect_equal_points(const std::vector<std::array<float, 3>>& read, const CSimplePointsMap& points) {
    ASSERT_EQ(read.size(), points.size());
    for (std::size_t i = 0; i < read.size(); ++i) {
        std::array<float, 3> p{};
        points.getPoint(i, p[0], p[1], p[2]);
        EXPECT_EQ(read[i], p);
    }
}

template <class Object>
void load(const std::filesystem::path& file, Object& object) {
    mrpt::io::CFileGZInputStream in(file.string());
    mrpt::serialization::archiveFrom(in) >> object;
}

}  // namespace

TEST(OutputGrid, map_servers_rules_give_the_states_of_the_grid) {
    const Folder folder;
    const auto grid = example_grid();
    FileList list;
    write_map_files(folder.path(), results_with({{"grid", grid}}), list);
    EXPECT_EQ(list.files, (std::vector<std::string>{"map.grid.pgm", "map.grid.yaml", "map.grid.gridmap"}));
    EXPECT_TRUE(list.warnings.empty());

    const auto map = read_as_map_server_does(folder / "map.grid.yaml");
    ASSERT_EQ(map.width, 37);
    ASSERT_EQ(map.height, 23);
    EXPECT_FLOAT_EQ(static_cast<float>(map.resolution), grid->getResolution());
    EXPECT_FLOAT_EQ(static_cast<float>(map.origin_x), grid->getXMin());
    EXPECT_FLOAT_EQ(static_cast<float>(map.origin_y), grid->getYMin());
    int states[3] = {0, 0, 0};
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x) {
            const double occupied = 1 - static_cast<double>(grid->getCell(x, y));
            const int expected = occupied > 0.65 ? 100 : occupied < 0.196 ? 0 : -1;
            EXPECT_EQ(map.data[static_cast<std::size_t>(y * map.width + x)], expected) << x << " " << y;
            ++states[expected == 100 ? 0 : expected == 0 ? 1 : 2];
        }
    for (const int count : states) EXPECT_GT(count, 100);
}

TEST(OutputGrid, mrpts_reader_gives_the_same_cells_at_the_same_places) {
    const Folder folder;
    const auto grid = example_grid();
    write_map_server_grid(folder / "m.yaml", *grid);
    for (const auto& again : {read_map_server_grid(folder / "m.yaml"),
                              std::make_shared<COccupancyGridMap2D>(
                                  COccupancyGridMap2D::FromROSMapServerYAML((folder / "m.yaml").string()))}) {
        ASSERT_EQ(again->getSizeX(), grid->getSizeX());
        ASSERT_EQ(again->getSizeY(), grid->getSizeY());
        for (unsigned y = 0; y < grid->getSizeY(); ++y)
            for (unsigned x = 0; x < grid->getSizeX(); ++x) {
                const int cx = static_cast<int>(x), cy = static_cast<int>(y);
                EXPECT_EQ(classify(1 - again->getCell(cx, cy)), classify(1 - grid->getCell(cx, cy)));
            }
        EXPECT_NEAR(again->idx2x(3), grid->idx2x(3), 1e-4);
        EXPECT_NEAR(again->idx2y(3), grid->idx2y(3), 1e-4);
    }
}

TEST(OutputGrid, reader_follows_modes_thresholds_and_negation) {
    const Folder folder;
    const unsigned char pixels[] = {0, 60, 127, 255};  // occupied by 1, 0.765, 0.502, 0
    std::ofstream(folder / "m.pgm") << "P5\n# drawn by hand\n4 1\n255\n"
                                    << std::string(reinterpret_cast<const char*>(pixels), 4);
    const auto free_of = [&](const std::string& more) {
        std::ofstream(folder / "m.yaml") << "image: m.pgm\nresolution: 0.5\norigin: [-1.0, 7.25, 0.0]\n"
                                         << more;
        const auto grid = read_map_server_grid(folder / "m.yaml");
        EXPECT_EQ(grid->getSizeX(), 4u);
        EXPECT_FLOAT_EQ(grid->getXMin(), -1.0f);
        std::vector<float> free;
        for (int x = 0; x < 4; ++x) free.push_back(std::round(100 * grid->getCell(x, 0)) / 100);
        return free;
    };
    using Cells = std::vector<float>;
    std::ofstream(folder / "block.yaml")
        << "# saved by hand\nimage: \"m.pgm\"  # beside\nresolution: 0.5\norigin:\n- -1.0\n- 7.25\n- 0\n";
    EXPECT_EQ(read_map_server_grid(folder / "block.yaml")->getXMin(), -1.0f);
    EXPECT_EQ(free_of(""), (Cells{0, 0, 0.5, 1}));
    EXPECT_EQ(free_of("negate: 1\n"), (Cells{1, 0.5, 0.5, 0}));
    EXPECT_EQ(free_of("mode: trinary\noccupied_thresh: 0.9\nfree_thresh: 0.6\n"), (Cells{0, 0.5, 1, 1}));
    const Cells scaled = free_of("mode: scale\noccupied_thresh: 0.9\nfree_thresh: 0.1\n");
    EXPECT_EQ(scaled[0], 0);
    EXPECT_NEAR(scaled[1], 1 - (0.765 - 0.1) / 0.8, 0.02);
    EXPECT_NEAR(scaled[2], 1 - (0.502 - 0.1) / 0.8, 0.02);
    EXPECT_EQ(free_of("mode: raw\n")[3], 0.5f);
    EXPECT_NEAR(free_of("mode: raw\n")[1], 0.4, 0.02);
}

TEST(OutputGrid, cells_follow_the_thresholds_of_the_file_in_all_modes_and_the_origin_may_be_turned) {
    const Folder folder;
    const unsigned char pixels[] = {0, 60, 127, 255, 30, 101};
    std::ofstream(folder / "m.pgm") << "P5\n3 2\n255\n"
                                    << std::string(reinterpret_cast<const char*>(pixels), 6);
    const auto cells_of = [&](const std::string& more) {
        std::ofstream(folder / "m.yaml") << "image: m.pgm\nresolution: 0.5\norigin: [-1.3, 7.2, 1.25]\n"
                                         << more;
        loopline::MapServerMap map;
        std::string problem;
        EXPECT_TRUE(read_map_server_map(folder / "m.yaml", map, problem)) << problem;
        EXPECT_EQ(map.width, 3u);
        EXPECT_EQ(map.T_map_picture.x_m, -1.3);
        EXPECT_EQ(map.T_map_picture.y_m, 7.2);
        EXPECT_EQ(map.T_map_picture.phi_rad, 1.25);
        std::string cells;  // lowest row first
        for (const MapCell cell : map.cells)
            cells += cell == MapCell::occupied ? '#' : cell == MapCell::free ? '.' : ' ';
        return cells;
    };
    EXPECT_EQ(cells_of(""), ".# ## ");  // 255 30 101, then 0 60 127
    EXPECT_EQ(cells_of("negate: 1\n"), "#. .  ");
    EXPECT_EQ(cells_of("occupied_thresh: 0.9\nfree_thresh: 0.6\n"), ".  # .");
    EXPECT_EQ(cells_of("mode: scale\noccupied_thresh: 0.4\nfree_thresh: 0.1\n"), ".#####");
    EXPECT_EQ(cells_of("occupied_thresh: 0.4\nfree_thresh: 0.1\nmode: trinary\n"), ".#####");
    EXPECT_EQ(cells_of("mode: raw\n"), "   .  ");
    EXPECT_EQ(cells_of("mode: raw\noccupied_thresh: 0.5\n"), "   .# ");
}

TEST(OutputGrid, reader_says_what_is_missing) {
    const Folder folder;
    write_map_server_grid(folder / "m.yaml", *example_grid());
    std::filesystem::remove(folder / "m.pgm");
    std::ofstream(folder / "junk.yaml") << "hello";
    std::ofstream(folder / "brackets.yaml") << "{[";
    std::ofstream(folder / "turned.yaml") << "image: m.pgm\nresolution: 0.5\norigin: [0, 0, 1]\n";
    std::ofstream(folder / "flat.yaml") << "image: m.pgm\nresolution: 0\norigin: [0, 0, 0]\n";
    std::ofstream(folder / "cut.pgm") << "P5\n60000 60000\n255\nabc";
    std::ofstream(folder / "cut.yaml") << "image: cut.pgm\nresolution: 1\norigin: [0, 0, 0]\n";
    std::ofstream(folder / "mode.yaml") << "image: m.pgm\nmode: odd\nresolution: 1\norigin: [0, 0, 0]\n";
    for (const char* file : {"nowhere.yaml", "m.yaml", "junk.yaml", "brackets.yaml", "turned.yaml",
                             "flat.yaml", "cut.yaml", "mode.yaml"}) {
        try {
            read_map_server_grid(folder / file);
            ADD_FAILURE() << file;
        } catch (const CommandError& e) {
            EXPECT_EQ(e.code(), exit_input_data);
            EXPECT_NE(std::string(e.what()).find(file), std::string::npos);
            EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos);
        }
    }
}

TEST(OutputGrid, gridmap_reloads_in_mrpt_with_every_value) {
    const Folder folder;
    const auto grid = example_grid();
    FileList list;
    write_map_files(folder.path(), results_with({{"grid", grid}}), list);
    COccupancyGridMap2D again;
    load(folder / "map.grid.gridmap", again);
    EXPECT_EQ(again.getRawMap(), grid->getRawMap());
    EXPECT_EQ(again.getXMin(), grid->getXMin());
    EXPECT_EQ(again.getYMax(), grid->getYMax());
    EXPECT_EQ(again.getResolution(), grid->getResolution());
}

TEST(OutputPoints, ply_and_pcd_hold_the_same_bits_and_mrpt_reads_the_ply) {
    const Folder folder;
    const auto points = example_points();
    FileList list;
    write_map_files(folder.path(), results_with({{"points", points}}), list);
    EXPECT_EQ(list.files, (std::vector<std::string>{"map.points.ply", "map.points.pcd"}));

    const std::string ply = content(folder / "map.points.ply"), pcd = content(folder / "map.points.pcd");
    EXPECT_EQ(ply.substr(0, 40), "ply\nformat binary_little_endian 1.0\ncomm");
    EXPECT_NE(ply.find("element vertex 1000\nproperty float x\n"), std::string::npos);
    expect_equal_points(floats_after(ply, "end_header\n"), *points);
    EXPECT_NE(pcd.find("\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 1000\nHEIGHT 1\n"),
              std::string::npos);
    EXPECT_NE(pcd.find("\nPOINTS 1000\n"), std::string::npos);
    expect_equal_points(floats_after(pcd, "DATA binary\n"), *points);

    CSimplePointsMap again;
    ASSERT_TRUE(again.loadFromPlyFile((folder / "map.points.ply").string()));
    ASSERT_EQ(again.size(), points->size());
    for (std::size_t i = 0; i < points->size(); ++i)
        EXPECT_EQ(again.getPointsBufferRef_y()[i], points->getPointsBufferRef_y()[i]);
}

TEST(OutputPoints, points_that_are_not_finite_are_left_out_and_counted) {
    const Folder folder;
    const auto points = example_points();
    points->setPointFast(3, std::numeric_limits<float>::quiet_NaN(), 0, 0);
    points->setPointFast(5, 0, std::numeric_limits<float>::infinity(), 0);
    FileList list;
    write_map_files(folder.path(), results_with({{"points", points}}), list);
    EXPECT_EQ(floats_after(content(folder / "map.points.ply"), "end_header\n").size(), 998u);
    EXPECT_EQ(floats_after(content(folder / "map.points.pcd"), "DATA binary\n").size(), 998u);
    ASSERT_EQ(list.warnings.size(), 2u);
    EXPECT_EQ(list.warnings[0].find("map.points.ply leaves out 2 points"), 0u);
}

TEST(OutputSimpleMap, reloads_in_mrpt_with_poses_covariances_and_scans) {
    const Folder folder;
    const auto map = example_simple_map();
    FileList list;
    write_map_files(folder.path(), results_with({{"keyframes", map}}), list);
    EXPECT_EQ(list.files, std::vector<std::string>{"map.simplemap"});
    CSimpleMap again;
    ASSERT_TRUE(again.loadFromFile((folder / "map.simplemap").string()));
    ASSERT_EQ(again.size(), map->size());
    for (std::size_t i = 0; i < map->size(); ++i) {
        const auto a = map->getAsPair(i), b = again.getAsPair(i);
        mrpt::math::CMatrixDouble66 cov_a, cov_b;
        mrpt::poses::CPose3D mean_a, mean_b;
        a.pose->getCovarianceAndMean(cov_a, mean_a);
        b.pose->getCovarianceAndMean(cov_b, mean_b);
        EXPECT_LT((mean_a.asVectorVal() - mean_b.asVectorVal()).norm(), 1e-12);
        EXPECT_TRUE(cov_a == cov_b);
        const auto scan = b.sf->getObservationByClass<mrpt::obs::CObservation2DRangeScan>();
        ASSERT_TRUE(scan);
        EXPECT_EQ(scan->getScanRange(2), 3.5f + static_cast<float>(i));
        EXPECT_FALSE(scan->getScanRangeValidity(1));
    }
}

TEST(OutputSimpleMap, keyframes_that_are_not_finite_are_left_out_and_counted) {
    const Folder folder;
    const auto map = example_simple_map();
    auto bad = mrpt::poses::CPose3DPDFGaussian::Create();
    bad->mean.x(std::numeric_limits<double>::quiet_NaN());
    map->set(2, bad, nullptr);
    FileList list;
    write_map_files(folder.path(), results_with({{"simplemap", map}}), list);
    CSimpleMap again;
    ASSERT_TRUE(again.loadFromFile((folder / "map.simplemap").string()));
    EXPECT_EQ(again.size(), 4u);
    ASSERT_EQ(list.warnings.size(), 1u);
}

TEST(OutputMapFiles, several_maps_of_a_kind_carry_their_names_and_no_name_leads_out_of_the_folder) {
    const Folder folder;
    std::filesystem::create_directory(folder / "run");
    FileList list;
    write_map_files(
        folder / "run",
        results_with({{"coarse", example_grid()}, {"../fine", example_grid()}, {"coarse", example_grid()}}),
        list);
    EXPECT_EQ(list.files,
              (std::vector<std::string>{"map.coarse.pgm", "map.coarse.yaml", "map.coarse.gridmap",
                                        "map.___fine.pgm", "map.___fine.yaml", "map.___fine.gridmap",
                                        "map.coarse_2.pgm", "map.coarse_2.yaml", "map.coarse_2.gridmap"}));
    for (const auto& file : list.files) EXPECT_TRUE(std::filesystem::exists(folder / "run" / file)) << file;
    EXPECT_EQ(read_as_map_server_does(folder / "run/map.coarse_2.yaml").width, 37);
}

TEST(OutputMapFiles, same_maps_same_bytes) {
    const Folder folder;
    const auto results =
        results_with({{"g", example_grid()}, {"p", example_points()}, {"s", example_simple_map()}});
    std::vector<std::string> files;
    for (const char* name : {"a", "b"}) {
        std::filesystem::create_directory(folder / name);
        FileList list;
        write_map_files(folder / name, results, list);
        files = list.files;
    }
    EXPECT_EQ(files.size(), 6u);
    for (const auto& file : files)
        EXPECT_EQ(content(folder / "a" / file), content(folder / "b" / file)) << file;
}
