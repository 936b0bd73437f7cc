/// Loops in metrics.json, and the pose graph read back by g2o's own definitions.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>

#include "api/loop_closer.h"
#include "output/g2o.h"
#include "output/map_files.h"
#include "output/metrics_json.h"
#include "output_test_support.h"

using namespace loopline;
using output_test::content;
using output_test::Folder;
using output_test::split;

namespace {

LoopDecision example_loop() {
    LoopDecision loop;
    loop.stamp_ns = 1'000'000'000'000 + 62'500'000'000;
    loop.old_stamp_ns = 1'000'000'000'000 + 4'250'000'000;
    loop.way_m = 41.5;
    loop.score = 0.75;
    loop.rival_score = 0.25;
    loop.shift_m = 0.42;
    loop.shift_rad = -M_PI / 6;
    loop.sigma_m = 0.5;
    loop.sigma_rad = M_PI / 90;
    loop.reason = "two matches agree";
    return loop;
}

RunRecord with_loops(std::vector<LoopDecision> loops) {
    RunRecord record;
    record.first_stamp_ns = 1'000'000'000'000;
    record.last_stamp_ns = 1'100'000'000'000;
    record.results.loops = std::move(loops);
    return record;
}

/// As g2o's types keep them.
struct G2o {
    struct Edge {
        std::size_t from = 0, to = 0;
        Eigen::Isometry2d measurement;
        Eigen::Matrix3d information;
    };
    std::map<std::size_t, Eigen::Isometry2d> vertices;
    std::vector<Edge> edges;
};

Eigen::Isometry2d se2(double x, double y, double phi) {
    return Eigen::Translation2d(x, y) * Eigen::Rotation2Dd(phi);
}

G2o read_g2o(const std::filesystem::path& file) {
    G2o graph;
    std::ifstream in(file);
    for (std::string line; std::getline(in, line);) {
        std::istringstream fields(line);
        std::string tag;
        fields >> tag;
        double x = 0, y = 0, phi = 0;
        if (tag == "VERTEX_SE2") {
            std::size_t id = 0;
            fields >> id >> x >> y >> phi;
            graph.vertices[id] = se2(x, y, phi);
        } else {
            EXPECT_EQ(tag, "EDGE_SE2");
            G2o::Edge edge;
            fields >> edge.from >> edge.to >> x >> y >> phi;
            edge.measurement = se2(x, y, phi);
            for (int row = 0; row < 3; ++row)
                for (int column = row; column < 3; ++column) {
                    fields >> edge.information(row, column);
                    edge.information(column, row) = edge.information(row, column);
                }
            graph.edges.push_back(edge);
        }
        EXPECT_TRUE(fields && (fields >> std::ws).eof()) << line;
    }
    return graph;
}

/// EdgeSE2::computeError() and chi2().
double chi2_of(const G2o& graph, const G2o::Edge& edge) {
    const Eigen::Isometry2d delta =
        edge.measurement.inverse() * graph.vertices.at(edge.from).inverse() * graph.vertices.at(edge.to);
    const Eigen::Vector3d error(delta.translation().x(), delta.translation().y(),
                                Eigen::Rotation2Dd(delta.rotation()).smallestAngle());
    return error.dot(edge.information * error);
}

/// e = (R_from' (t_to - t_from) - t, turn), along the axes of `from`.
double chi2_of(const PoseGraph& graph, const PoseGraph::Constraint& constraint) {
    const Pose2 T = graph.poses[constraint.from].inverse() * graph.poses[constraint.to];
    const Eigen::Vector3d error(T.x_m - constraint.T_from_to.x_m, T.y_m - constraint.T_from_to.y_m,
                                wrap_to_pi(T.phi_rad - constraint.T_from_to.phi_rad));
    return error.dot(constraint.information * error);
}

/// Poses all round, constraints far from them, information of no special direction.
PoseGraph random_graph(std::size_t poses, std::size_t constraints) {
    std::mt19937_64 random(7);
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> angle(-M_PI, M_PI);
    PoseGraph graph;
    for (std::size_t i = 0; i < poses; ++i)
        graph.poses.push_back({10 * normal(random), 10 * normal(random), angle(random)});
    for (std::size_t i = 0; i < constraints; ++i) {
        PoseGraph::Constraint constraint;
        constraint.from = static_cast<std::uint32_t>(random() % poses);
        constraint.to = static_cast<std::uint32_t>(random() % poses);
        constraint.T_from_to = {normal(random), normal(random), angle(random)};
        const Eigen::Matrix3d root = Eigen::Matrix3d::NullaryExpr([&] { return 10 * normal(random); });
        constraint.information = root * root.transpose();
        graph.constraints.push_back(constraint);
    }
    return graph;
}

}  // namespace

TEST(OutputLoops, metrics_hold_one_object_a_loop_in_their_units) {
    LoopDecision accepted = example_loop(), waits = example_loop();
    accepted.accepted = true;
    waits.waits = true;
    const auto m = metrics_json(with_loops({example_loop(), accepted, waits}));
    ASSERT_EQ(m["loops"].size(), 3u);
    const auto& loop = m["loops"][0];
    EXPECT_EQ(loop["number"], 1);
    EXPECT_EQ(m["loops"][2]["number"], 3);
    // As [grid_slam] named_loops and refuse_loops take it.
    EXPECT_EQ(loop["loop"], loop_name(example_loop().stamp_ns, example_loop().old_stamp_ns));
    EXPECT_EQ(loop["stamp_s"], 62.5);
    EXPECT_EQ(loop["old_stamp_s"], 4.25);
    EXPECT_EQ(loop["way_m"], 41.5);
    EXPECT_EQ(loop["score"], 0.75);
    EXPECT_EQ(loop["rival_score"], 0.25);
    EXPECT_EQ(loop["shift_m"], 0.42);
    EXPECT_NEAR(loop["shift_deg"].get<double>(), -30, 1e-12);
    EXPECT_EQ(loop["sigma_m"], 0.5);
    EXPECT_NEAR(loop["sigma_deg"].get<double>(), 2, 1e-12);
    EXPECT_EQ(loop["reason"], "two matches agree");
    EXPECT_EQ(loop["decision"], "refused");
    EXPECT_EQ(m["loops"][1]["decision"], "accepted");
    EXPECT_EQ(m["loops"][2]["decision"], "waits");
}

TEST(OutputLoops, without_loops_there_is_no_key_and_what_is_not_finite_is_absent) {
    EXPECT_FALSE(metrics_json(with_loops({})).contains("loops"));
    LoopDecision loop = example_loop();
    loop.rival_score = std::numeric_limits<double>::quiet_NaN();
    loop.shift_rad = std::numeric_limits<double>::infinity();
    const auto m = metrics_json(with_loops({loop}));
    EXPECT_FALSE(m["loops"][0].contains("rival_score"));
    EXPECT_FALSE(m["loops"][0].contains("shift_deg"));
    EXPECT_EQ(m["loops"][0]["shift_m"], 0.42);
}

TEST(OutputLoops, the_graph_comes_back_with_every_bit_of_its_poses) {
    const Folder folder;
    const PoseGraph graph = random_graph(60, 200);
    EXPECT_EQ(write_g2o(folder / "a.g2o", graph), 0u);
    const auto lines = split(content(folder / "a.g2o"), '\n');
    ASSERT_EQ(lines.size(), 260u);
    for (std::size_t i = 0; i < 260; ++i) {
        const auto fields = split(lines[i], ' ');
        const bool is_pose = i < 60;
        ASSERT_EQ(fields.size(), is_pose ? 5u : 12u);
        const Pose2& pose = is_pose ? graph.poses[i] : graph.constraints[i - 60].T_from_to;
        const std::size_t first = is_pose ? 2 : 3;
        EXPECT_EQ(std::stod(fields[first]), pose.x_m);
        EXPECT_EQ(std::stod(fields[first + 1]), pose.y_m);
        EXPECT_EQ(std::stod(fields[first + 2]), pose.phi_rad);
        if (is_pose) {
            EXPECT_EQ(fields[1], std::to_string(i));
        }
    }
}

TEST(OutputLoops, g2os_chi2_is_ours) {
    const Folder folder;
    const PoseGraph graph = random_graph(60, 200);
    write_g2o(folder / "a.g2o", graph);
    const G2o read = read_g2o(folder / "a.g2o");
    ASSERT_EQ(read.vertices.size(), 60u);
    ASSERT_EQ(read.edges.size(), 200u);
    for (std::size_t i = 0; i < 200; ++i) {
        EXPECT_EQ(read.edges[i].from, graph.constraints[i].from);
        EXPECT_EQ(read.edges[i].to, graph.constraints[i].to);
        const double ours = chi2_of(graph, graph.constraints[i]);
        EXPECT_NEAR(chi2_of(read, read.edges[i]), ours, 1e-9 * ours);
    }
}

TEST(OutputLoops, no_edge_hangs_on_a_pose_that_is_left_out) {
    const Folder folder;
    PoseGraph graph;
    graph.poses = {{0, 0, 0}, {1, 0, 0}, {2, std::numeric_limits<double>::quiet_NaN(), 0}};
    for (const auto& [from, to] : {std::pair{0u, 1u}, {1u, 2u}, {2u, 0u}, {0u, 3u}, {1u, 0u}})
        graph.constraints.push_back({from, to, {1, 0, 0}, Eigen::Matrix3d::Identity()});
    graph.constraints.back().information(2, 2) = std::numeric_limits<double>::infinity();
    Results results;
    results.pose_graph = graph;
    FileList list;
    write_map_files(folder.path(), results, list);
    EXPECT_EQ(list.files, std::vector<std::string>{"pose_graph.g2o"});
    ASSERT_EQ(list.warnings.size(), 1u);
    EXPECT_NE(list.warnings[0].find("pose_graph.g2o leaves out 5 poses and constraints"), std::string::npos);
    EXPECT_EQ(content(folder / "pose_graph.g2o"),
              "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0\nEDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n");
    results.pose_graph = PoseGraph{};
    FileList empty;
    write_map_files(folder.path(), results, empty);
    EXPECT_TRUE(empty.files.empty());
}
