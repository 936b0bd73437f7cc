#include "simulation/town/recorded_path.h"

#include <Eigen/SparseCholesky>
#include <cmath>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <unordered_map>

#include "simulation/town/cubic_spline.h"
#include "simulation/town/plan_cell.h"

namespace loopline::simulation {
namespace {

constexpr double meeting_m = 10;          ///< on the plan: farther apart is another place
constexpr std::size_t way_between = 100;  ///< poses; nearer ones follow each other
constexpr double meeting_weight = 0.01;   ///< against the change from pose to pose
constexpr double bend_weight = 1000;      ///< of the change of that: it bends over some 20 poses

using Vector7d = Eigen::Matrix<double, 7, 1>;

std::int64_t place_key(double x_m, double y_m) {
    return cell_key(cell_of(x_m, meeting_m), cell_of(y_m, meeting_m));
}

/// Poses at one place, the second the nearest of an earlier visit.
struct Meeting {
    std::size_t later, earlier;
    double apart_m;  ///< on the plan: the ground may slope from one to the other
};
std::vector<Meeting> meetings(const std::vector<Pose3>& poses) {
    std::unordered_map<std::int64_t, std::vector<std::size_t>> of_place;
    std::vector<Meeting> found;
    for (std::size_t i = 0; i < poses.size(); ++i) {
        const Eigen::Vector2d here_m = poses[i].translation_m.head<2>();
        double least_m = meeting_m;
        std::size_t nearest = i;
        for (const double dx : {-meeting_m, 0.0, meeting_m})
            for (const double dy : {-meeting_m, 0.0, meeting_m}) {
                const auto there = of_place.find(place_key(here_m.x() + dx, here_m.y() + dy));
                if (there == of_place.end()) continue;
                for (const std::size_t j : there->second) {
                    const double apart_m = (poses[j].translation_m.head<2>() - here_m).norm();
                    if (j + way_between > i || apart_m >= least_m) continue;
                    least_m = apart_m;
                    nearest = j;
                }
            }
        if (nearest != i) found.push_back({i, nearest, least_m});
        of_place[place_key(here_m.x(), here_m.y())].push_back(i);
    }
    return found;
}

}  // namespace

std::vector<Pose3> RecordedPathSettings::read() const {
    std::vector<Pose3> all = read_kitti_poses(file());
    if (level_revisits) simulation::level_revisits(all);
    const auto begin = static_cast<std::size_t>(first), wanted = static_cast<std::size_t>(poses);
    if (begin + 2 > all.size())
        throw std::runtime_error(file() + " has " + std::to_string(all.size()) +
                                 " poses, so [path] first leaves no way to go");
    const std::size_t end =
        wanted == 0 ? all.size() : std::min(all.size(), begin + std::max<std::size_t>(wanted, 2));
    std::vector<Pose3> part(all.begin() + static_cast<std::ptrdiff_t>(begin),
                            all.begin() + static_cast<std::ptrdiff_t>(end));
    if (begin > 0) {
        const Pose3 T_map_file = part.front().inverse();
        for (Pose3& pose : part) pose = T_map_file * pose;
    }
    return part;
}

std::vector<Pose3> read_kitti_poses(const std::string& file) {
    std::ifstream stream(file);
    if (!stream) throw std::runtime_error("can't read " + file);
    Eigen::Matrix3d base_from_camera;  // x ahead, y left, z up from x right, y down, z ahead
    base_from_camera << 0, 0, 1, -1, 0, 0, 0, -1, 0;
    std::vector<Pose3> poses;
    for (std::string line; std::getline(stream, line);) {
        std::istringstream words(line);
        Eigen::Matrix<double, 3, 4, Eigen::RowMajor> camera;
        for (int i = 0; i < 12; ++i) words >> camera.data()[i];
        if (!words || !camera.allFinite())
            throw std::runtime_error(file + ": line " + std::to_string(poses.size() + 1) +
                                     " is no row of 12 numbers");
        const Eigen::Matrix3d rotation =
            base_from_camera * camera.leftCols<3>() * base_from_camera.transpose();
        poses.emplace_back(base_from_camera * camera.col(3), Eigen::Quaterniond(rotation).normalized());
    }
    if (poses.size() < 2) throw std::runtime_error(file + " holds no path");
    return poses;
}

void level_revisits(std::vector<Pose3>& poses) {
    const auto pairs = meetings(poses);
    if (pairs.empty()) return;
    // Least squares of sum (c[i+1] - c[i])^2 + bend sum (c[i+2] - 2 c[i+1] + c[i])^2 + weight sum (z[i] +
    // c[i] - z[j] - c[j])^2, with c[0] = 0.
    const auto n = static_cast<int>(poses.size());
    std::vector<Eigen::Triplet<double>> terms{{0, 0, 1}};
    Eigen::VectorXd right = Eigen::VectorXd::Zero(n);
    const auto add = [&](int i, int j, double weight, double wanted_m) {
        terms.insert(terms.end(), {{i, i, weight}, {j, j, weight}, {i, j, -weight}, {j, i, -weight}});
        right[i] += weight * wanted_m;
        right[j] -= weight * wanted_m;
    };
    for (int i = 1; i < n; ++i) add(i, i - 1, 1, 0);
    constexpr double second[] = {1, -2, 1};
    for (int i = 0; i + 2 < n; ++i)
        for (int a = 0; a < 3; ++a)
            for (int b = 0; b < 3; ++b) terms.emplace_back(i + a, i + b, bend_weight * second[a] * second[b]);
    for (const auto& [i, j, apart_m] : pairs)
        add(static_cast<int>(i), static_cast<int>(j), meeting_weight * std::pow(1 - apart_m / meeting_m, 4),
            poses[j].translation_m.z() - poses[i].translation_m.z());
    Eigen::SparseMatrix<double> normal(n, n);
    normal.setFromTriplets(terms.begin(), terms.end());
    const Eigen::VectorXd change_m = Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>(normal).solve(right);
    for (int i = 0; i < n; ++i)
        poses[static_cast<std::size_t>(i)].translation_m.z() += change_m[i] - change_m[0];
}

TrueMotion motion_through(const std::vector<Pose3>& poses, double rate_hz, StampNs step_ns) {
    std::vector<Vector7d> knots;
    for (const Pose3& pose : poses) {
        Vector7d knot;
        knot << pose.translation_m, pose.rotation.coeffs();
        if (!knots.empty() && knot.tail<4>().dot(knots.back().tail<4>()) < 0) knot.tail<4>() *= -1;
        knots.push_back(knot);
    }
    const CubicSpline<Vector7d> spline(knots);
    const auto interval_ns = static_cast<StampNs>(std::llround(1e9 / rate_hz));
    const StampNs end_ns = interval_ns * static_cast<StampNs>(poses.size()) - step_ns;
    TrueMotion motion;
    std::vector<FloorAttitude> attitudes;
    for (StampNs time_ns = 0; time_ns <= end_ns; time_ns += step_ns) {
        const Vector7d at = spline.at(static_cast<double>(time_ns) / static_cast<double>(interval_ns));
        const Eigen::Matrix3d R =
            Eigen::Quaterniond(Eigen::Vector4d(at.tail<4>().normalized())).toRotationMatrix();
        const Pose2 planar{at[0], at[1], std::atan2(R(1, 0), R(0, 0))};
        if (time_ns == 0)
            motion = TrueMotion(planar, step_ns);
        else
            motion.append_pose(planar);
        attitudes.push_back({at[2], -std::asin(R(2, 0)), std::atan2(R(2, 1), R(2, 2))});
    }
    motion.lift(std::move(attitudes));
    return motion;
}

}  // namespace loopline::simulation
