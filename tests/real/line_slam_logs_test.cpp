/// The three experiments by lines, as a user runs them, against their published or simulated reference.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <vector>

#include "api/pose2.h"
#include "support/built_files.h"
#include "support/run_program.h"
#include "support/shared_data.h"

using namespace loopline;

namespace {

constexpr const char* demo_folder =
    "/usr/share/mrpt/datasets/graphslam-engine-demos/action_observations_map/";
constexpr const char* telecom_log =
    "/usr/share/mrpt/datasets/2006-01ENE-21-SENA_Telecom Faculty_one_loop_only.rawlog";

struct StampedPose {
    double t_s;
    Pose2 pose;
};

std::vector<StampedPose> read_tum(const std::filesystem::path& file) {
    std::ifstream in(file);
    std::vector<StampedPose> path;
    for (std::string line; std::getline(in, line);) {
        if (line.empty() || line[0] == '#') continue;
        std::istringstream words(line);
        double t, x, y, z, qx, qy, qz, qw;
        if (words >> t >> x >> y >> z >> qx >> qy >> qz >> qw)
            path.push_back({t, {x, y, 2 * std::atan2(qz, qw)}});
    }
    return path;
}

/// Root mean square distance after the best rigid motion, of poses whose true one is within 0.06 s.
double ate_rmse_m(const std::vector<StampedPose>& estimate, const std::filesystem::path& truth_file) {
    std::ifstream in(truth_file);
    std::vector<StampedPose> truth;
    for (StampedPose p; in >> p.t_s >> p.pose.x_m >> p.pose.y_m >> p.pose.phi_rad;) truth.push_back(p);
    std::vector<Eigen::Vector2d> a, b;
    for (const auto& e : estimate) {
        const auto nearest = std::min_element(truth.begin(), truth.end(), [&](const auto& x, const auto& y) {
            return std::abs(x.t_s - e.t_s) < std::abs(y.t_s - e.t_s);
        });
        if (nearest == truth.end() || std::abs(nearest->t_s - e.t_s) > 0.06) continue;
        a.push_back(e.pose.translation());
        b.push_back(nearest->pose.translation());
    }
    if (a.size() < 1000) return 1e9;
    Eigen::MatrixXd A(2, a.size()), B(2, b.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
        A.col(static_cast<Eigen::Index>(i)) = a[i];
        B.col(static_cast<Eigen::Index>(i)) = b[i];
    }
    const Eigen::MatrixXd T = Eigen::umeyama(A, B, false);
    const Eigen::MatrixXd moved = (T.topLeftCorner(2, 2) * A).colwise() + T.col(2).head(2);
    return std::sqrt((moved - B).colwise().squaredNorm().mean());
}

/// Runs an experiment of ini/real without maps and pictures; returns its directory.
std::filesystem::path run(const test::TemporaryFolder& folder, const std::string& ini,
                          const std::string& name, const std::vector<std::string>& more = {},
                          const std::vector<std::string>& environment = {}) {
    const std::filesystem::path out = folder / name;
    const std::string experiment = test::source_folder() + "/ini/real/" + ini;
    std::vector<std::string> words{test::loopline_program(), "run", experiment, "--out", out, "--quiet"};
    for (const char* off : {"outputs.maps=false", "outputs.snapshots=false", "outputs.report=false"})
        words.insert(words.end(), {"--set", off});
    words.insert(words.end(), more.begin(), more.end());
    const auto result = test::run_program(words, environment);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return out;
}

TEST(LineSlamLogs, telecom_faculty_closes_its_loop_and_repeats_to_the_byte) {
    if (!std::filesystem::exists(telecom_log)) GTEST_SKIP() << "mrpt-common is not installed";
    const test::TemporaryFolder folder;
    const auto out = run(folder, "telecom_faculty_lines.ini", "first");
    const auto path = read_tum(out / "trajectory.tum");
    ASSERT_EQ(path.size(), 225u) << "a pose for every scan";
    // Where MRPT's rbpf-slam and icp-slam agree; odometry says (-4.80, -21.16, -1.862).
    EXPECT_LT((path.back().pose.translation() - Eigen::Vector2d(4.27, -18.47)).norm(), 0.15);
    EXPECT_LT(std::abs(wrap_to_pi(path.back().pose.phi_rad + 1.530)), 1.0 * M_PI / 180);
    const auto again = run(folder, "telecom_faculty_lines.ini", "second");
    for (const char* file : {"trajectory.tum", "trajectory_online.tum", "covariance.csv"})
        EXPECT_EQ(test::file_text(out / file), test::file_text(again / file)) << file;
}

TEST(LineSlamLogs, hand_drawn_worlds_within_their_bars) {
    if (!std::filesystem::exists(demo_folder)) GTEST_SKIP() << "mrpt-common is not installed";
    const test::TemporaryFolder folder;
    for (const auto& [name, bar_m] : {std::pair{"simul", 0.10}, std::pair{"range_030_bearing_015", 0.25}}) {
        const std::string log = std::string(demo_folder) + name + ".rawlog";
        const auto out = run(folder, "mrpt_demo_lines.ini", name, {"--rawlog", log});
        EXPECT_LT(ate_rmse_m(read_tum(out / "trajectory.tum"), log + ".GT.txt"), bar_m) << name;
    }
}

TEST(LineSlamLogs, intel_lab_by_the_published_relations) {
    const std::filesystem::path data = test::shared_data();
    if (!std::filesystem::exists(data / "intel/intel_part1_full_rate.sf.rawlog"))
        GTEST_SKIP() << "no Intel log in LOOPLINE_DATA";
    const test::TemporaryFolder folder;
    const auto out = run(folder, "intel_lines.ini", "intel", {},
                         {"LOOPLINE_DATA=" + std::filesystem::absolute(data).string()});
    const auto metrics = nlohmann::json::parse(test::file_text(out / "metrics.json"));
    EXPECT_GT(metrics.at("relations_used").get<int>(), 1000);
    EXPECT_LT(metrics.at("relations_translation_mean_m").get<double>(), 0.035);
    EXPECT_LT(metrics.at("relations_rotation_mean_deg").get<double>(), 0.6);
}

}  // namespace
