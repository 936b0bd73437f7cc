/// Points of a cloud keep their distance, and what that is good for: walls are no stairs.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <map>
#include <random>

#include "cloud_map/cloud_mapper.h"
#include "support/cloud_map_scans.h"
#include "support/run_program.h"

using namespace loopline;
using namespace loopline::cloud_map;
using namespace loopline::cloud_map_scans;

namespace {

/// As a lidar at the origin meets them, one after the other, with its axes those of the map.
lidar::SpinningScan scan_of_points(const std::vector<Eigen::Vector3d>& p_lidar_m, int k) {
    lidar::SpinningScan scan;
    scan.stamp_ns = start_ns + 200'000'000LL * k;
    scan.end_s = 0.1;
    for (std::size_t i = 0; i < p_lidar_m.size(); ++i) {
        const Eigen::Vector3f p = p_lidar_m[i].cast<float>();
        scan.points.push_back({p.x(), p.y(), p.z(), static_cast<float>(1e-6 * double(i))});
    }
    scan.ring_begin = {0, static_cast<std::uint32_t>(scan.points.size())};
    return scan;
}

/// The rule, as it is said: a list of all points that were kept, and each return is compared with all.
class ListedPoints {
 public:
    explicit ListedPoints(double voxel_m) : per_voxel_(1 / voxel_m) {}

    /// Whether the return is kept.
    bool insert(const Eigen::Vector3d& p_map_m) {
        std::array<std::int64_t, 3> at;
        for (int axis = 0; axis < 3; ++axis)
            at[static_cast<std::size_t>(axis)] =
                std::llround(std::floor(p_map_m[axis] * per_voxel_ * offset_parts));
        for (const auto& other : kept_) {
            if (std::abs(at[0] - other[0]) >= offset_parts) continue;
            std::int64_t d2 = 0;
            bool is_same_voxel = true;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                d2 += (at[axis] - other[axis]) * (at[axis] - other[axis]);
                is_same_voxel &= at[axis] >> 8 == other[axis] >> 8;
            }
            if (is_same_voxel || d2 < offset_parts * offset_parts) return false;
        }
        kept_.push_back(at);
        return true;
    }

 private:
    double per_voxel_;
    std::vector<std::array<std::int64_t, 3>> kept_;
};

}  // namespace

TEST(CloudMapSpacing, keeps_the_returns_that_a_list_of_points_would_also_where_tiles_were_put_away) {
    CloudMapSettings settings;
    settings.voxel_m = 0.3;
    settings.min_range_m = 2;
    settings.max_range_m = 18;
    settings.removal.remove_moving = false;
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> level(-12, 12), height(-0.5, 0.5);
    for (const Eigen::Vector3d& middle_m :
         {Eigen::Vector3d(3000.3, -40.2, 7.7), Eigen::Vector3d(-25.1, 0.1, -0.2)}) {
        const test::TemporaryFolder folder;
        CloudMapper mapper(settings, 2);
        mapper.keep_in(folder.path(), "map");
        ListedPoints list(settings.voxel_m);
        std::map<std::uint16_t, std::pair<Eigen::Vector3d, double>> kept;  // place and time, by intensity
        std::size_t returns = 0;
        StampNs first_ns = 0;
        // There, where all of that is put away, and there again; from one side to the other, so that points
        // at the edge of a tile come before those of the tile beside it.
        for (int k = 0; k < 3; ++k) {
            std::vector<Eigen::Vector3d> p_m;
            for (int i = 0; i < 12000; ++i)
                p_m.emplace_back(level(random), level(random), 3 + height(random));
            if (k == 2)
                std::sort(p_m.begin(), p_m.end(), [](const auto& a, const auto& b) { return a.x() > b.x(); });
            const lidar::SpinningScan scan = scan_of_points(p_m, k);
            const PoseAt pose = standing(
                {middle_m + Eigen::Vector3d(k == 1 ? 300 : 0, 0, 0), Eigen::Quaterniond::Identity()});
            SweepMotion motion;
            ASSERT_TRUE(motion.follow(scan, pose));
            std::vector<std::uint16_t> intensity;
            if (k == 0) first_ns = scan.stamp_ns;
            for (const auto& p : scan.points) {
                intensity.push_back(static_cast<std::uint16_t>(returns++));
                const double range_m = Eigen::Vector3d(p.x_m, p.y_m, p.z_m).norm();
                if (range_m < 2 || range_m > 18 || !list.insert(motion.p_map_m(p))) continue;
                kept[intensity.back()] = {motion.p_map_m(p),
                                          1e-9 * double(scan.stamp_ns - first_ns) + p.time_s};
            }
            ASSERT_TRUE(mapper.add(scan, intensity, pose));
        }
        mapper.finish();
        ASSERT_LT(returns, 65536u);
        const auto& points = mapper.cloud().points();
        ASSERT_EQ(points.size(), kept.size());
        EXPECT_GT(points.size(), 5000u);
        for (const CloudPoint& point : points) {
            const auto found = kept.find(point.intensity);
            ASSERT_NE(found, kept.end());
            const auto& [p_map_m, time_s] = found->second;
            ASSERT_LT((point.p_map_m() - p_map_m).cwiseAbs().maxCoeff(), settings.voxel_m / 512 + 1e-4);
            ASSERT_NEAR(point.time_s(), time_s, 1.1e-4);
        }
        EXPECT_GT(nearest_two_m(mapper.cloud(), settings.voxel_m), settings.voxel_m - rounding_m);
    }
}

TEST(CloudMapSpacing, blocks_know_where_each_point_is_whatever_is_held_given_dropped_and_gone) {
    std::mt19937_64 random(14);
    std::uniform_int_distribution<unsigned> place(0, Block::voxels - 1), part(0, offset_parts - 1);
    std::uniform_int_distribution<int> beside(-1, Block::edge), chance(0, 3);
    const auto any_offset = [&] {
        VoxelOffset offset;
        for (auto& along : offset) along = static_cast<std::uint8_t>(part(random));
        return offset;
    };
    int near = 0, far = 0;
    for (int block_of_many = 0; block_of_many < 20; ++block_of_many) {
        Block block;
        std::map<unsigned, VoxelOffset> there;
        for (int round = 0; round < 30; ++round) {
            for (int k = 0; k < 20; ++k) {
                Candidate candidate;
                candidate.place = static_cast<std::uint16_t>(place(random));
                const VoxelOffset offset = any_offset();
                if (there.emplace(candidate.place, offset).second) block.hold(candidate, offset);
            }
            block.judge([&](Candidate& candidate) {
                const int what = chance(random);
                if (what == 0) there.erase(candidate.place);
                return what == 0 ? Block::Fate::dropped : what == 1 ? Block::Fate::given : Block::Fate::stays;
            });
            block.look_again([&](unsigned voxel, std::uint8_t&) {
                const bool stays = chance(random) > 0;
                if (!stays) there.erase(voxel);
                return stays;
            });
            for (unsigned voxel = 0; voxel < Block::voxels; ++voxel)
                ASSERT_EQ(block.is_taken(voxel), there.count(voxel) == 1);
            for (const auto& [voxel, offset] : there) ASSERT_EQ(block.offset_of(voxel), offset);
            for (int k = 0; k < 100; ++k) {
                const Block::Local at{beside(random), beside(random), beside(random)};
                const VoxelOffset offset = any_offset();
                bool is_near = false;
                for (const auto& [voxel, other] : there) {
                    int d2 = 0;
                    for (unsigned axis = 0; axis < 3; ++axis) {
                        const int d = (static_cast<int>(voxel >> (6 - 3 * axis) & 7) - at[axis]) * 256 +
                                      other[axis] - offset[axis];
                        d2 += d * d;
                    }
                    is_near |= d2 < 256 * 256;
                }
                ASSERT_EQ(block.has_nearer(at, offset), is_near);
                ++(is_near ? near : far);
            }
        }
    }
    EXPECT_GT(near, 5000);
    EXPECT_GT(far, 5000);
}

TEST(CloudMapSpacing, walls_at_a_small_angle_to_the_axes_have_the_normals_that_their_scatter_promises) {
    std::mt19937_64 random(15);
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> unit(-1, 1);
    CloudMapSettings settings;
    settings.removal.remove_moving = false;
    for (const double half_m : {0.25, 0.5}) {  // of the piece of wall that has its plane fitted
        double squares = 0;
        int count = 0;
        for (int wall = 0; wall < 150; ++wall) {
            const double tilt_rad = 0.1 * std::abs(unit(random)) + 0.02, roll_rad = M_PI * unit(random);
            const Eigen::Matrix3d R_map_wall = (Eigen::AngleAxisd(roll_rad, Eigen::Vector3d::UnitX()) *
                                                Eigen::AngleAxisd(tilt_rad, Eigen::Vector3d::UnitY()) *
                                                Eigen::AngleAxisd(-roll_rad, Eigen::Vector3d::UnitX()))
                                                   .toRotationMatrix();  // its normal is about x
            const Eigen::Vector3d middle_m(10 + unit(random), unit(random), unit(random));
            CloudMapper mapper(settings, 1);
            for (int k = 0; k < 20; ++k) {
                // From another place each time; noise is along the beam.
                const Eigen::Vector3d lidar_m(0, 3 * unit(random), unit(random));
                std::vector<Eigen::Vector3d> p_m;
                for (int i = 0; i < 300; ++i) {
                    const Eigen::Vector3d beam_m =
                        middle_m + R_map_wall * Eigen::Vector3d(0, 0.8 * unit(random), 0.8 * unit(random)) -
                        lidar_m;
                    p_m.push_back(beam_m + 0.02 * normal(random) * beam_m.normalized());
                }
                mapper.add(scan_of_points(p_m, k), {}, standing({lidar_m, Eigen::Quaterniond::Identity()}));
            }
            mapper.finish();
            std::vector<Eigen::Vector3d> of_wall_m;
            Eigen::Vector3d mean_m = Eigen::Vector3d::Zero();
            for (const CloudPoint& point : mapper.cloud().points()) {
                const Eigen::Vector3d p_wall_m = R_map_wall.transpose() * (point.p_map_m() - middle_m);
                if (p_wall_m.tail<2>().cwiseAbs().maxCoeff() > half_m) continue;
                of_wall_m.push_back(p_wall_m);
                mean_m += p_wall_m;
            }
            const auto n = static_cast<double>(of_wall_m.size());
            ASSERT_GT(n, 8);
            mean_m /= n;
            Eigen::Matrix3d scatter_m2 = Eigen::Matrix3d::Zero();
            for (const Eigen::Vector3d& p : of_wall_m) scatter_m2 += (p - mean_m) * (p - mean_m).transpose();
            const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(scatter_m2);
            const double variance_m2 = axes.eigenvalues()[0] / (n - 3);
            for (const int along : {1, 2}) {
                const double error_rad = axes.eigenvectors()(0, along) / axes.eigenvectors()(0, 0);
                squares += error_rad * error_rad / (variance_m2 / axes.eigenvalues()[along]);
                ++count;
            }
        }
        EXPECT_GT(squares / count, 0.3) << half_m;
        EXPECT_LT(squares / count, 1.5) << half_m;
    }
}
