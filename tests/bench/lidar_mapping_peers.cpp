/// What does a sweep of a spinning lidar cost, and how far does the path drift, beside the registrations of
/// PCL on the same sweeps in the same run: GICP and ICP from sweep to sweep, and NDT against a growing map,
/// as NDT mapping does it; how far from one another are the paths. One thread. Arguments: a log and the TUM
/// file of its truth (or -), how many sweeps are taken (0: all), and "instant" if none is to be undistorted,
/// as the peers' never are.
#include <mrpt/io/CFileGZInputStream.h>
#include <mrpt/obs/CObservation.h>
#include <mrpt/serialization/CArchive.h>
#include <pcl/filters/voxel_grid.h>
#include <pcl/registration/gicp.h>
#include <pcl/registration/icp.h>
#include <pcl/registration/ndt.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <string>
#include <vector>

#include "evaluate/association.h"
#include "evaluate/read_trajectory.h"
#include "lidar/observation_scan.h"
#include "lidar_mapping/sweep_mapping.h"

using namespace loopline;

namespace {

using Cloud = pcl::PointCloud<pcl::PointXYZ>;

double cpu_s() {
    timespec t{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

std::vector<lidar::SpinningScan> sweeps_of(const std::string& log, std::size_t most, bool instant) {
    std::vector<lidar::SpinningScan> sweeps;
    lidar::SweepConvention convention;
    if (instant) convention.sweep_s = 0;
    lidar::SpinningScanReader reader{convention};
    mrpt::io::CFileGZInputStream file(log);
    auto archive = mrpt::serialization::archiveFrom(file);
    lidar::SpinningScan scan;
    try {
        while (most == 0 || sweeps.size() < most) {
            const auto object = archive.ReadObject();
            const auto observation = std::dynamic_pointer_cast<mrpt::obs::CObservation>(object);
            if (observation && reader.read(*observation, scan)) sweeps.push_back(scan);
        }
    } catch (const std::exception&) {
        // the log's end
    }
    return sweeps;
}

/// In the vehicle's frame, one point of each cube.
Cloud::Ptr thinned(const lidar::SpinningScan& scan, float voxel_m) {
    auto all = std::make_shared<Cloud>(), thin = std::make_shared<Cloud>();
    for (const lidar::SpinningPoint& p : scan.points) {
        const float range2 = p.x_m * p.x_m + p.y_m * p.y_m + p.z_m * p.z_m;
        if (range2 < 1.5F * 1.5F || range2 > 100.0F * 100.0F) continue;
        const Eigen::Vector3d q = scan.T_base_lidar * Eigen::Vector3d(p.x_m, p.y_m, p.z_m);
        all->push_back({static_cast<float>(q.x()), static_cast<float>(q.y()), static_cast<float>(q.z())});
    }
    pcl::VoxelGrid<pcl::PointXYZ> filter;
    filter.setLeafSize(voxel_m, voxel_m, voxel_m);
    filter.setInputCloud(all);
    filter.filter(*thin);
    return thin;
}

/// Poses T_map_base, one a sweep.
using Path = std::vector<Eigen::Matrix4f>;

Path ours(const std::vector<lidar::SpinningScan>& sweeps) {
    lidar_mapping::SweepMapping mapping({}, 1);
    Path path;
    for (const auto& sweep : sweeps) {
        const auto& T = mapping.add(sweep).state.T_map_base;
        Eigen::Matrix4f M = Eigen::Matrix4f::Identity();
        M.topLeftCorner<3, 3>() = T.rotation.toRotationMatrix().cast<float>();
        M.topRightCorner<3, 1>() = T.translation_m.cast<float>();
        path.push_back(M);
    }
    return path;
}

/// Each sweep against the one before, from the motion before.
Path from_sweep_to_sweep(const std::vector<lidar::SpinningScan>& sweeps,
                         pcl::Registration<pcl::PointXYZ, pcl::PointXYZ>& registration) {
    Path path;
    Cloud::Ptr before;
    Eigen::Matrix4f motion = Eigen::Matrix4f::Identity();
    for (const auto& sweep : sweeps) {
        const Cloud::Ptr now = thinned(sweep, 0.5F);
        if (before) {
            Cloud moved;
            registration.setInputTarget(before);
            registration.setInputSource(now);
            registration.align(moved, motion);
            motion = registration.getFinalTransformation();
        }
        path.push_back(path.empty() ? Eigen::Matrix4f::Identity().eval() : (path.back() * motion).eval());
        before = now;
    }
    return path;
}

/// Against the map of all sweeps before, which takes a sweep each metre.
Path by_ndt_mapping(const std::vector<lidar::SpinningScan>& sweeps) {
    pcl::NormalDistributionsTransform<pcl::PointXYZ, pcl::PointXYZ> ndt;
    ndt.setResolution(1);
    ndt.setStepSize(0.1);
    ndt.setTransformationEpsilon(1e-3);
    ndt.setMaximumIterations(30);
    Path path;
    const auto map = std::make_shared<Cloud>();
    Eigen::Matrix4f motion = Eigen::Matrix4f::Identity(), added = motion;
    for (const auto& sweep : sweeps) {
        const Cloud::Ptr now = thinned(sweep, 0.5F);
        Eigen::Matrix4f T = Eigen::Matrix4f::Identity();
        if (!path.empty()) {
            Cloud moved;
            ndt.setInputSource(now);
            ndt.align(moved, path.back() * motion);
            T = ndt.getFinalTransformation();
            motion = path.back().inverse() * T;
        }
        if (path.empty() || (T - added).topRightCorner<3, 1>().norm() > 1) {
            Cloud placed;
            pcl::transformPointCloud(*thinned(sweep, 0.2F), placed, T);
            *map += placed;
            ndt.setInputTarget(map);
            added = T;
        }
        path.push_back(T);
    }
    return path;
}

/// Mean error of the shift over segments of 50 m of the true way, percent.
double drift_percent(const std::vector<lidar::SpinningScan>& sweeps, const Path& path,
                     const std::string& truth) {
    StampedPath poses;
    for (const StampedPose& pose : read_trajectory(truth, "the truth").poses) poses.push_back(pose);
    ReferencePoses reference(poses, 0.1, ReferencePoses::Kind::poses);
    std::vector<Eigen::Matrix4d> real;
    std::vector<double> way_m;
    for (const auto& sweep : sweeps) {
        const auto middle_ns = sweep.stamp_ns + static_cast<StampNs>(1e9 * (sweep.begin_s + sweep.end_s) / 2);
        const auto T = reference.at(middle_ns);
        Eigen::Matrix4d M = Eigen::Matrix4d::Identity();
        if (T) {
            M.topLeftCorner<3, 3>() = T->rotation.toRotationMatrix();
            M.topRightCorner<3, 1>() = T->translation_m;
        }
        way_m.push_back(real.empty() ? 0 : way_m.back() + (M - real.back()).topRightCorner<3, 1>().norm());
        real.push_back(M);
    }
    double sum = 0, count = 0;
    for (std::size_t i = 0; i < real.size(); i += 10) {
        std::size_t j = i;
        while (j < real.size() && way_m[j] < way_m[i] + 50) ++j;
        if (j == real.size()) break;
        const Eigen::Matrix4d found = (path[i].inverse() * path[j]).cast<double>(),
                              off = (real[i].inverse() * real[j]).inverse() * found;
        sum += off.topRightCorner<3, 1>().norm() / 50;
        ++count;
    }
    return count > 0 ? 100 * sum / count : NAN;
}

/// Rms of the distance of two paths, one laid on the other.
double apart_m(const Path& a, const Path& b) {
    Eigen::Matrix3Xd p(3, a.size()), q(3, a.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
        p.col(static_cast<Eigen::Index>(i)) = a[i].topRightCorner<3, 1>().cast<double>();
        q.col(static_cast<Eigen::Index>(i)) = b[i].topRightCorner<3, 1>().cast<double>();
    }
    const Eigen::Matrix4d T = Eigen::umeyama(p, q, false);
    const Eigen::Matrix3Xd off = (T.topLeftCorner<3, 3>() * p).colwise() + T.topRightCorner<3, 1>().eval();
    return std::sqrt((off - q).squaredNorm() / static_cast<double>(a.size()));
}

}  // namespace

int main(int count, char** arguments) {
    if (count < 3) {
        std::fprintf(stderr, "lidar_mapping_peers LOG TRUTH.tum|- [SWEEPS [instant]]\n");
        return 2;
    }
    const auto sweeps = sweeps_of(arguments[1], count > 3 ? std::strtoul(arguments[3], nullptr, 10) : 0,
                                  count > 4 && std::string(arguments[4]) == "instant");
    const std::string truth = arguments[2];
    pcl::GeneralizedIterativeClosestPoint<pcl::PointXYZ, pcl::PointXYZ> gicp;
    gicp.setMaxCorrespondenceDistance(2);
    gicp.setMaximumIterations(30);
    pcl::IterativeClosestPoint<pcl::PointXYZ, pcl::PointXYZ> icp;
    icp.setMaxCorrespondenceDistance(2);
    icp.setMaximumIterations(50);
    const struct {
        const char* name;
        std::function<Path()> run;
    } methods[] = {{"lidar_mapping", [&] { return ours(sweeps); }},
                   {"PCL GICP, sweep to sweep", [&] { return from_sweep_to_sweep(sweeps, gicp); }},
                   {"PCL ICP, sweep to sweep", [&] { return from_sweep_to_sweep(sweeps, icp); }},
                   {"PCL NDT, map", [&] { return by_ndt_mapping(sweeps); }}};
    double first_ms = 0;
    std::vector<Path> paths;
    std::printf("%zu sweeps\n%-26s %10s %8s  %s\n", sweeps.size(), "", "ms", "ratio",
                "from those above, m; drift");
    for (const auto& method : methods) {
        const double start = cpu_s();
        paths.push_back(method.run());
        const Path& path = paths.back();
        const double ms = 1e3 * (cpu_s() - start) / static_cast<double>(sweeps.size());
        if (first_ms == 0) first_ms = ms;
        std::printf("%-26s %10.1f %8.1f", method.name, ms, ms / first_ms);
        for (std::size_t k = 0; k + 1 < paths.size(); ++k) std::printf(" %9.3f", apart_m(path, paths[k]));
        if (truth != "-") std::printf(" %9.2f%%", drift_percent(sweeps, path, truth));
        std::printf("\n");
        std::fflush(stdout);
    }
    return 0;
}
