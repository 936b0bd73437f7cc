/// Content from files: every kind that a run writes, and what is refused.
#include <gtest/gtest.h>
#include <mrpt/maps/CSimpleMap.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/poses/CPose3DPDFGaussian.h>

#include <cstring>

#include "commands/command.h"
#include "output/line_map_csv.h"
#include "output/map_files.h"
#include "output/map_server_grid.h"
#include "output/mrpt_object_file.h"
#include "output/point_cloud_files.h"
#include "output/stored_cloud_files.h"
#include "output/tum.h"
#include "pipeline/run_record.h"
#include "render/scene_content.h"
#include "support/points_in.h"
#include "support/run_program.h"

using namespace loopline;
namespace fs = std::filesystem;

namespace {

Trajectory path_of(int poses) {
    Trajectory path;
    for (int i = 0; i < poses; ++i)
        path.append(i, 1'000'000'000LL * i, Pose3(Pose2{0.5 * i, 0.1 * i, 0.01 * i}), Matrix6d::Identity());
    return path;
}

mrpt::maps::CSimplePointsMap::Ptr three_points() {
    auto points = mrpt::maps::CSimplePointsMap::Create();
    points->insertPoint(1.5f, -2, 0.25f);
    points->insertPoint(3, 4, 5);
    points->insertPoint(-1e4f, 0, 1);
    return points;
}

std::string bytes_of_floats(std::initializer_list<float> values) {
    std::string bytes;
    for (const float value : values) {
        char part[4];
        std::memcpy(part, &value, 4);
        bytes.append(part, 4);
    }
    return bytes;
}

void expect_refused(const fs::path& file, const std::string& words) {
    try {
        scene_from_path(file);
        ADD_FAILURE() << file << " was read";
    } catch (const CommandError& error) {
        EXPECT_EQ(error.code(), exit_input_data);
        EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
        EXPECT_NE(std::string(error.what()).find(file.filename().string()), std::string::npos)
            << error.what();
    }
}

}  // namespace

TEST(RenderPointFiles, what_the_writers_wrote) {
    const test::TemporaryFolder folder;
    const auto points = three_points();
    write_ply(folder / "p.ply", *points);
    write_pcd(folder / "p.pcd", *points);
    for (const auto& read : {test::points_in(folder / "p.ply"), test::points_in(folder / "p.pcd")}) {
        ASSERT_EQ(read.size(), 3u);
        EXPECT_EQ(read[0], Eigen::Vector3f(1.5f, -2, 0.25f));
        EXPECT_EQ(read[2], Eigen::Vector3f(-1e4f, 0, 1));
    }
}

TEST(RenderPointFiles, other_programs_layouts) {
    const test::TemporaryFolder folder;
    const std::vector<Eigen::Vector3f> expected = {{1, 2, 3}, {4, 5, 6}};
    EXPECT_EQ(
        test::points_in(folder.write(
            "a.ply",
            "ply\r\nformat ascii 1.0\r\ncomment x\r\nelement vertex 3\r\nproperty uchar red\r\n"
            "property double z\r\nproperty float x\r\nproperty float y\r\nelement face 0\r\n"
            "property list uchar int vertex_indices\r\nend_header\r\n255 3 1 2\r\n0 6 4 5\r\n0 nan 1 1\r\n")),
        expected);
    EXPECT_EQ(
        test::points_in(folder.write(
            "b.ply",
            "ply\nformat binary_little_endian 1.0\nelement vertex 2\nproperty uchar red\nproperty float x\n"
            "property float y\nproperty float z\nend_header\n" +
                std::string("\x07") + bytes_of_floats({1, 2, 3}) + "\x09" + bytes_of_floats({4, 5, 6}))),
        expected);
    EXPECT_EQ(
        test::points_in(folder.write("a.pcd",
                                     "# .PCD v.7\nVERSION .7\nFIELDS x y z rgb\nSIZE 4 4 4 4\nTYPE F F F "
                                     "U\nCOUNT 1 1 1 1\nWIDTH 2\nHEIGHT 1\n"
                                     "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 2\nDATA ascii\n1 2 3 9\n4 5 6 9\n")),
        expected);
    EXPECT_EQ(test::points_in(folder.write(
                  "b.pcd",
                  "VERSION .7\nFIELDS n x y z\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 2 1 1 1\nWIDTH 2\nHEIGHT 1\n"
                  "POINTS 2\nDATA binary\n" +
                      bytes_of_floats({8, 8, 1, 2, 3, 8, 8, 4, 5, 6}))),
              expected);
}

TEST(RenderPointFiles, of_a_cloud_are_drawn_from_the_file_whatever_the_stride) {
    const test::TemporaryFolder folder;
    StoredCloud cloud;
    std::vector<Eigen::Vector3f> all;
    for (std::int32_t k = 0; k < 12'345; ++k) {
        CloudPoint point;
        point.place = {7 * k - 30'000, -3 * k, k % 11'000};
        cloud.push_back(point);
        all.push_back(point.p_map_m().cast<float>());
    }
    write_ply(folder / "c.ply", cloud);
    write_pcd(folder / "c.pcd", cloud);
    write_las(folder / "c.las", cloud);
    for (const char* name : {"c.ply", "c.pcd", "c.las"}) {
        const auto content = scene_from_path(folder / name);
        ASSERT_NE(content.cloud, nullptr) << name;
        EXPECT_EQ(content.cloud->size(), all.size());
        for (const std::size_t stride : {1, 7, 2'000, 20'000}) {
            std::size_t k = 0;
            content.cloud->for_each(stride, [&](const Eigen::Vector3f& p) {
                ASSERT_LT((p - all[k]).norm(), 1e-6f) << name << k;
                k += stride;
            });
            EXPECT_EQ(k, (all.size() + stride - 1) / stride * stride) << name;
        }
    }
}

TEST(RenderPointFiles, of_las_1_4_count_with_64_bits_and_have_units_and_an_origin) {
    const test::TemporaryFolder folder;
    std::string las(375 + 2 * 30, '\0');
    const auto put = [&las](std::size_t offset, auto value) {
        std::memcpy(&las[offset], &value, sizeof value);
    };
    las.replace(0, 4, "LASF");
    put(24, std::uint8_t{1});
    put(25, std::uint8_t{4});
    put(94, std::uint16_t{375});
    put(96, std::uint32_t{375});
    put(104, std::uint8_t{6});
    put(105, std::uint16_t{30});
    put(247, std::uint64_t{2});
    for (std::size_t axis = 0; axis < 3; ++axis) {
        put(131 + 8 * axis, 0.01);
        put(155 + 8 * axis, 100.0 * static_cast<double>(axis + 1));
        put(375 + 30 + 4 * axis, std::int32_t{-50});
    }
    const auto points = test::points_in(folder.write("a.las", las));
    ASSERT_EQ(points.size(), 2u);
    EXPECT_EQ(points[0], Eigen::Vector3f(100, 200, 300));
    EXPECT_EQ(points[1], Eigen::Vector3f(99.5f, 199.5f, 299.5f));

    expect_refused(folder.write("cut.las", las.substr(0, las.size() - 1)), "ends after 1 of 2 points");
    expect_refused(folder.write("head.las", las.substr(0, 100)), "ends inside its header");
    expect_refused(folder.write("other.las", "PK"), "not a LAS file");
    put(104, std::uint8_t{128 + 6});
    expect_refused(folder.write("packed.las", las), "is compressed");
    put(104, std::uint8_t{6});
    put(105, std::uint16_t{0});
    expect_refused(folder.write("rows.las", las), "it is damaged");
}

TEST(RenderPointFiles, damaged_ones_are_refused_with_a_sentence) {
    const test::TemporaryFolder folder;
    const std::string head =
        "ply\nformat binary_little_endian 1.0\nelement vertex 99999999999\nproperty float x\nproperty float "
        "y\nproperty float z\n";
    expect_refused(folder.write("cut.ply", head + "end_header\nabc"), "ends after 0 of 99999999999 points");
    expect_refused(folder.write("head.ply", head), "ends inside its header");
    expect_refused(folder.write("big.ply", "ply\nformat binary_big_endian 1.0\n"), "binary_big_endian");
    expect_refused(
        folder.write("list.ply",
                     "ply\nformat ascii 1.0\nelement vertex 1\nproperty list uchar int x\nend_header\n1 1\n"),
        "list");
    expect_refused(
        folder.write(
            "flat.ply",
            "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nend_header\n1 1\n"),
        "no field z");
    expect_refused(folder.write("other.ply", "solid\n"), "not a PLY file");
    expect_refused(folder.write("none.ply",
                                "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float "
                                "y\nproperty float z\nend_header\n"),
                   "nothing to draw");
    expect_refused(
        folder.write("packed.pcd",
                     "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nPOINTS 1\nDATA binary_compressed\n"),
        "binary_compressed");
    expect_refused(folder.write("empty.pcd", ""), "not a PCD file");
}

TEST(RenderScene, every_kind_of_file) {
    const test::TemporaryFolder folder;
    write_tum(folder / "trajectory.tum", path_of(7), Estimate::latest);
    write_tum(folder / "odometry.tum", path_of(5), Estimate::latest);
    EXPECT_EQ(scene_from_path(folder / "trajectory.tum").estimated_path.size(), 7u);
    EXPECT_EQ(scene_from_path(folder / "odometry.tum").odometry_path.size(), 5u);
    EXPECT_NEAR(scene_from_path(folder / "trajectory.tum").estimated_path[6].translation_m.x(), 3, 1e-12);
    EXPECT_EQ(scene_from_path(folder / "trajectory.tum").title, "trajectory.tum");

    MapLine line;
    line.start_m = {1, 2};
    line.end_m = {3, 2};
    write_line_map_csv(folder / "map.lines.csv", {line});
    EXPECT_EQ(scene_from_path(folder / "map.lines.csv").lines->at(0).end_m, line.end_m);

    auto grid = mrpt::maps::COccupancyGridMap2D::Create(0.f, 2.f, 0.f, 1.f, 0.1f);
    grid->setCell(3, 4, 0.02f);
    write_mrpt_object(folder / "map.grid.gridmap", *grid);
    write_map_server_grid(folder / "map.grid.yaml", *grid);
    for (const char* name : {"map.grid.gridmap", "map.grid.yaml"}) {
        const auto read = scene_from_path(folder / name).grid;
        ASSERT_TRUE(read) << name;
        EXPECT_EQ(read->getSizeX(), grid->getSizeX()) << name;
        EXPECT_LT(read->getPos(0.35f, 0.45f), 0.1f) << name;
    }

    mrpt::maps::CSimpleMap keyframes;
    mrpt::obs::CObservation2DRangeScan scan;
    const float ranges[] = {2, 2, 2};
    const char valid[] = {1, 1, 0};
    scan.aperture = static_cast<float>(M_PI);
    scan.maxRange = 10;
    scan.loadFromVectors(3, ranges, valid);
    auto frame = mrpt::obs::CSensoryFrame::Create();
    frame->insert(mrpt::obs::CObservation::Ptr(std::make_shared<mrpt::obs::CObservation2DRangeScan>(scan)));
    keyframes.insert(mrpt::poses::CPose3DPDFGaussian::Create(mrpt::poses::CPose3D(5, 6, 0, M_PI / 2, 0, 0)),
                     frame);
    write_mrpt_object(folder / "map.simplemap", keyframes);
    const SceneContent simple = scene_from_path(folder / "map.simplemap");
    ASSERT_EQ(simple.estimated_path.size(), 1u);
    EXPECT_NEAR(simple.estimated_path[0].yaw_rad(), M_PI / 2, 1e-9);
    // Beams to the right and ahead of a sensor that looks along y.
    ASSERT_EQ(simple.points_m.size(), 2u);
    EXPECT_LT((simple.points_m[0] - Eigen::Vector3f(7, 6, 0)).norm(), 1e-4);
    EXPECT_LT((simple.points_m[1] - Eigen::Vector3f(5, 8, 0)).norm(), 1e-4);

    write_ply(folder / "map.points.ply", *three_points());
    write_ply(folder / "map.points_odometry.ply", *three_points());
    const SceneContent whole = scene_from_path(folder.path());
    EXPECT_EQ(whole.estimated_path.size(), 7u);
    EXPECT_EQ(whole.odometry_path.size(), 5u);
    EXPECT_EQ(whole.points_m.size(), 3u);
    EXPECT_EQ(whole.points_odometry_m.size(), 3u);
    EXPECT_TRUE(whole.lines && whole.grid);
    EXPECT_EQ(whole.title, folder.path().filename().string());
    EXPECT_EQ(scene_from_path(folder.path().string() + "/.").title, folder.path().filename().string());
}

TEST(RenderScene, before_and_after_points_survive_the_run_directory) {
    const test::TemporaryFolder folder;
    Results results, odometry_results;
    results.maps.push_back({"points", three_points()});
    auto moved = three_points();
    moved->insertPoint(7, 7, 7);
    odometry_results.maps.push_back({"points", moved});
    FileList list;
    write_map_files(folder.path(), results, list);
    write_odometry_points(folder.path(), odometry_results, list);
    EXPECT_EQ(list.files.back(), "map.points_odometry.ply");
    const SceneContent content = scene_from_path(folder.path());
    EXPECT_EQ(content.points_m.size(), 3u);
    EXPECT_EQ(content.points_odometry_m.size(), 4u);
}

TEST(RenderScene, what_can_not_be_drawn_is_refused_with_a_sentence) {
    const test::TemporaryFolder folder;
    expect_refused(folder / "missing.tum", "There is no file or folder");
    expect_refused(folder.path(), "nothing to draw");
    expect_refused(folder.write("notes.txt", "hello"), "of no kind that can be drawn");
    expect_refused(folder.write("trajectory.tum", "# empty\n"), "nothing to draw");
    expect_refused(folder.write("bad.tum", "1 2 3\n"), "bad.tum");
    expect_refused(folder.write("bad.gridmap", "not an object"), "not a grid map");
    expect_refused(folder.write("bad.simplemap", "not an object"), "not a simple map");
    expect_refused(folder.write("bad.yaml", "image: nowhere.pgm\n"), "bad.yaml");
    expect_refused(folder.write("bad.csv", "1,2,3\n"), "bad.csv");
}

TEST(RenderScene, from_a_run_in_memory) {
    const Trajectory trajectory = path_of(4), odometry = path_of(6);
    RunRecord record;
    EXPECT_TRUE(scene_from_record(record, "Empty").estimated_path.empty());
    record.trajectory = &trajectory;
    record.odometry = &odometry;
    record.results.line_map = LineMap(2);
    auto points = three_points();
    points->insertPoint(NAN, 1, 1);
    record.results.maps.push_back({"points", points});
    record.results.maps.push_back(
        {"grid", mrpt::maps::COccupancyGridMap2D::Create(0.f, 1.f, 0.f, 1.f, 0.1f)});
    record.odometry_results.maps.push_back({"points", three_points()});
    const SceneContent content = scene_from_record(record, "Title");
    EXPECT_EQ(content.title, "Title");
    EXPECT_EQ(content.estimated_path.size(), 4u);
    EXPECT_EQ(content.odometry_path.size(), 6u);
    EXPECT_EQ(content.lines->size(), 2u);
    EXPECT_EQ(content.points_m.size(), 3u) << "NaN is left out";
    EXPECT_EQ(content.points_odometry_m.size(), 3u);
    EXPECT_TRUE(content.grid);
}
