/// The metrics against other people's programs and data: the reference implementation of the relations metric
/// and a minimal ATE program (run where Python and the data are there; their frozen figures otherwise need
/// the data alone), and KITTI's segments on KITTI's own paths with a known distortion.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "commands/command.h"
#include "evaluate/absolute_error.h"
#include "evaluate/kitti_segments.h"
#include "evaluate/read_trajectory.h"
#include "evaluate/relations.h"
#include "support/run_program.h"
#include "support/shared_data.h"

using namespace loopline;
using namespace loopline::test;

namespace {

/// Intel lab, a mapper's path with and without a carrier and with a small gap, and raw odometry.
struct RelationsCase {
    const char *estimate, *odometry;
    double max_gap_s;
    /// By eval_relations.py: count, translation mean and rms in m, rotation mean and rms in degrees.
    std::size_t used;
    double translation_mean_m, translation_rms_m, rotation_mean_deg, rotation_rms_deg;
};

const RelationsCase relations_cases[] = {
    {"corrected_1of5.txt", "", 2, 2984, 0.097434241, 0.133530311, 3.044227757, 5.238161912},
    {"corrected_1of5.txt", "odometry_raw_13631.txt", 2, 2984, 0.064675809, 0.094426261, 2.249678845,
     3.384355863},
    {"corrected_1of5.txt", "", 0.2, 1138, 0.105338129, 0.150252916, 3.208111106, 5.652901317},
    {"odometry_raw_13631.txt", "", 2, 2984, 7.386655464, 16.130873122, 39.357632336, 66.543464767},
};

RelationsError evaluate_case(const RelationsCase& c) {
    const auto folder = shared_data() / "intel";
    std::vector<StampedPose> odometry;
    if (*c.odometry) odometry = read_trajectory(folder / c.odometry, "the odometry").poses;
    return relations_error(read_relations(folder / "intel.relations"),
                           read_trajectory(folder / c.estimate, "the estimate").poses, odometry,
                           {c.max_gap_s});
}

bool has_python() {
    return run_program({"python3", "-c", "pass"}).exit_code == 0;
}

}  // namespace

TEST(EvaluateReferences, relations_equal_the_frozen_figures_of_the_reference_implementation) {
    NEEDS_SHARED_DATA("intel/intel.relations");
    for (const auto& c : relations_cases) {
        const RelationsError error = evaluate_case(c);
        EXPECT_EQ(error.translation_m.count, c.used) << c.estimate << ' ' << c.odometry;
        EXPECT_NEAR(error.translation_m.mean, c.translation_mean_m, 1e-6) << c.estimate << ' ' << c.odometry;
        EXPECT_NEAR(error.translation_m.rmse, c.translation_rms_m, 1e-6) << c.estimate << ' ' << c.odometry;
        EXPECT_NEAR(error.rotation_deg.mean, c.rotation_mean_deg, 1e-5) << c.estimate << ' ' << c.odometry;
        EXPECT_NEAR(error.rotation_deg.rmse, c.rotation_rms_deg, 1e-5) << c.estimate << ' ' << c.odometry;
    }
}

TEST(EvaluateReferences, every_relation_equals_the_reference_implementation_run_here) {
    NEEDS_SHARED_DATA("tools/eval_relations.py");
    if (!has_python()) GTEST_SKIP() << "python3 is not there";
    const auto folder = shared_data() / "intel";
    // Its seconds are doubles, 0.12 us apart at this epoch, which counts where stamps out of order set far
    // poses side by side in time. With the epoch taken off in decimals, both are exact.
    const std::string script = R"(
import sys; sys.path.insert(0, sys.argv[1]); sys.dont_write_bytecode = True
import eval_relations as e
from decimal import Decimal
def copy(source, name, stamps):
    with open(sys.argv[2] + '/' + name, 'w') as out:
        for line in open(source):
            p = line.split()
            for k in stamps: p[k] = str(Decimal(p[k]) - 976052857)
            out.write(' '.join(p) + '\n')
    return out.name
relations, path = copy(sys.argv[3], 'r', (0, 1)), e.read(copy(sys.argv[4], 't', (0,)))
odometry = e.read(copy(sys.argv[5], 'o', (0,))) if sys.argv[5] else None
n, s, t, r = e.evaluate(relations, path, odometry, float(sys.argv[6]))
for v in zip(t, r): print('%.15g %.15g' % v)
)";
    for (const auto& c : relations_cases) {
        const TemporaryFolder copies;
        const auto result =
            run_program({"python3", "-c", script, (shared_data() / "tools").string(), copies.path().string(),
                         (folder / "intel.relations").string(), (folder / c.estimate).string(),
                         *c.odometry ? (folder / c.odometry).string() : "", std::to_string(c.max_gap_s)});
        ASSERT_EQ(result.exit_code, 0) << result.err;
        const RelationsError error = evaluate_case(c);
        std::istringstream lines(result.out);
        double translation_m = 0, rotation_deg = 0;
        std::size_t i = 0;
        for (; lines >> translation_m >> rotation_deg; ++i) {
            ASSERT_LT(i, error.translations_m.size());
            ASSERT_NEAR(error.translations_m[i], translation_m, 1e-7) << c.estimate << " relation " << i;
            ASSERT_NEAR(error.rotations_deg[i], rotation_deg, 1e-6) << c.estimate << " relation " << i;
        }
        EXPECT_EQ(i, error.translations_m.size());
    }
}

TEST(EvaluateReferences, ate_equals_the_minimal_program) {
    NEEDS_SHARED_DATA("tools/ate.py");
    NEEDS_SHARED_DATA("intel/corrected_1of5.txt");
    if (!has_python()) GTEST_SKIP() << "python3 is not there";
    // 0.0501 s: no difference of two stamps of this log lies so near to it that rounding decides.
    const std::string reference = (shared_data() / "intel/corrected_1of5.txt").string();
    const std::string estimate = (shared_data() / "intel/odometry_raw_13631.txt").string();
    const auto theirs =
        run_program({"python3", (shared_data() / "tools/ate.py").string(), reference, estimate, "0.0501"});
    ASSERT_EQ(theirs.exit_code, 0) << theirs.err;
    const auto ours = run_loopline({"evaluate", "--estimate", estimate, "--reference", reference,
                                    "--max-difference-s", "0.0501", "--json"});
    ASSERT_EQ(ours.exit_code, 0) << ours.err;
    const auto json = nlohmann::json::parse(ours.out);
    char expected[100];
    std::snprintf(expected, sizeof expected, "poses %d  ATE rmse %.3f m mean %.3f max %.3f\n",
                  json["poses_matched"].get<int>(), json["ate_rmse_m"].get<double>(),
                  json["ate_mean_m"].get<double>(), json["ate_max_m"].get<double>());
    EXPECT_EQ(theirs.out, expected);
}

TEST(EvaluateReferences, kitti_paths_with_a_known_distortion) {
    NEEDS_SHARED_DATA("kitti_odometry_gt_poses/07.txt");
    // Segment counts by hand from the paths' lengths: awk over the file with the kit's rule.
    const struct {
        const char* sequence;
        std::size_t segments;
    } paths[] = {{"04", 43}, {"07", 317}};
    for (const auto& path : paths) {
        const auto truth =
            read_trajectory(shared_data() / "kitti_odometry_gt_poses" / (std::string(path.sequence) + ".txt"),
                            "truth")
                .poses;
        auto pairs = associate_by_index(truth, truth);
        // 1 % too long: each segment's error is 1 % of the distance between its ends, which its length
        // bounds.
        for (auto& pair : pairs) pair.T_map_base_estimate.translation_m *= 1.01;
        const KittiError scaled = kitti_error(pairs);
        EXPECT_EQ(scaled.segments.size(), path.segments);
        double expected = 0;
        for (const auto& s : scaled.segments) {
            const double between_m =
                (truth[s.last].T_map_base.translation_m - truth[s.first].T_map_base.translation_m).norm();
            EXPECT_NEAR(s.translation_m, 0.01 * between_m, 1e-9);
            expected += between_m / s.length_m;
        }
        EXPECT_NEAR(scaled.translation_percent, expected / static_cast<double>(scaled.segments.size()), 1e-9);
        EXPECT_LT(scaled.rotation_deg_per_m, 1e-12);

        // A heading error that grows by 0.001 degree a pose, about the camera's own vertical.
        for (std::size_t i = 0; i < pairs.size(); ++i) {
            const double angle_rad = static_cast<double>(i) * 0.001 * M_PI / 180;
            pairs[i].T_map_base_estimate = pairs[i].T_ref_base_reference;
            pairs[i].T_map_base_estimate.rotation = pairs[i].T_ref_base_reference.rotation *
                                                    Eigen::AngleAxisd(angle_rad, Eigen::Vector3d::UnitY());
        }
        const KittiError turned = kitti_error(pairs);
        ASSERT_EQ(turned.segments.size(), path.segments);
        double worst = 0;
        for (const auto& s : turned.segments) {
            const Pose3 difference =
                pairs[s.first].T_ref_base_reference.inverse() * pairs[s.last].T_ref_base_reference;
            // Brute force: the angle of R_first^T dR R_last against R_last, by the trace.
            const Eigen::Matrix3d a =
                Eigen::AngleAxisd(static_cast<double>(s.first) * 0.001 * M_PI / 180, Eigen::Vector3d::UnitY())
                    .toRotationMatrix();
            const Eigen::Matrix3d b =
                Eigen::AngleAxisd(static_cast<double>(s.last) * 0.001 * M_PI / 180, Eigen::Vector3d::UnitY())
                    .toRotationMatrix();
            const Eigen::Matrix3d R = difference.rotation.toRotationMatrix();
            const Eigen::Matrix3d E = R.transpose() * (a.transpose() * R * b);
            worst = std::max(
                worst, std::abs(std::acos(std::clamp((E.trace() - 1) / 2, -1.0, 1.0)) - s.rotation_rad));
        }
        EXPECT_LT(worst, 1e-6);
    }
}

TEST(EvaluateReferences, mrpts_own_ground_truth_files_are_read) {
    const std::string folder = "/usr/share/mrpt/datasets/graphslam-engine-demos/action_observations_map/";
    const auto truth = read_trajectory(folder + "simul.rawlog.GT.txt", "truth");
    EXPECT_EQ(truth.poses.size(), 1734u);
    EXPECT_EQ(truth.poses[1].stamp_ns, 1464600321041046000);
    double way_m = 0;
    for (std::size_t i = 1; i < truth.poses.size(); ++i)
        way_m +=
            (truth.poses[i].T_map_base.translation_m - truth.poses[i - 1].T_map_base.translation_m).norm();
    EXPECT_NEAR(way_m, 197, 1);
}
