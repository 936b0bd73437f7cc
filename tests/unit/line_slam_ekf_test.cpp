/// The filter's algebra: against the textbook's full matrices, and against itself with everything active.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <random>

#include "line_slam/ekf.h"
#include "support/line_slam_world.h"

using namespace loopline;
using namespace loopline::line_slam;

namespace {

struct Drive {
    std::mt19937_64 random{3};
    DriveParameters drive;
    std::vector<test::WorldWall> walls = test::square_ring(20, 10);
    Pose2 T_world_base{-7.5, -7.5, 0};

    /// Goes on along a wobbling course and returns what the wheels say.
    WheelTravel go() {
        std::uniform_real_distribution<double> turn(-0.1, 0.15);
        const WheelTravel truth = wheel_travel({0.2, 0, turn(random)}, drive.track_width_m);
        T_world_base = T_world_base * moved(truth, drive.track_width_m);
        return test::measured(truth, drive, {}, random);
    }
    LineObservation see(std::size_t wall) {
        LineObservation z;
        z.line = predicted_line(T_world_base, walls[wall].line());
        z.start_m = T_world_base.inverse() * walls[wall].from_m;
        z.end_m = T_world_base.inverse() * walls[wall].to_m;
        test::disturb(z, 0.02, random);
        return z;
    }
};

TEST(LineSlamEkf, update_is_the_textbooks_joint_update) {
    Drive d;
    Ekf filter(d.drive);
    filter.predict(d.go());
    std::vector<LineObservation> z{d.see(0), d.see(1), d.see(4)};
    for (const auto& o : z) filter.augment(o);
    filter.predict(d.go());
    z = {d.see(0), d.see(1), d.see(4)};

    // P, H, R as they stand in the paper's eq. (14)-(16), corrected for a joint update.
    Eigen::MatrixXd S(6, 6);
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) S.block<2, 2>(2 * i, 2 * j) = filter.predicted_covariance(i, j);
    EXPECT_LT((S - S.transpose()).norm(), 1e-12);
    const Eigen::MatrixXd prior = S;
    Eigen::VectorXd v(6);
    for (int i = 0; i < 3; ++i) {
        S.block<2, 2>(2 * i, 2 * i) += z[static_cast<std::size_t>(i)].covariance;
        v.segment<2>(2 * i) = innovation(z[static_cast<std::size_t>(i)].line,
                                         predicted_line(filter.T_map_base(), filter.line(i)));
    }
    // In the space of the observations: posterior = prior - prior S^-1 prior, and the residual shrinks
    // accordingly.
    const Eigen::MatrixXd posterior = prior - prior * S.inverse() * prior;
    const Eigen::VectorXd shift = prior * S.inverse() * v;
    const auto before = [&](int i) { return predicted_line(filter.T_map_base(), filter.line(i)); };
    const std::vector<PlanarLine> old{before(0), before(1), before(2)};
    ASSERT_TRUE(filter.update({{0, 0}, {1, 1}, {2, 2}}, z));
    for (int i = 0; i < 3; ++i) {
        const Eigen::Vector2d moved_by = difference(before(i), old[static_cast<std::size_t>(i)]);
        EXPECT_LT((moved_by - shift.segment<2>(2 * i)).norm(), 2e-3) << "first order";
        for (int j = 0; j < 3; ++j)
            EXPECT_LT((filter.predicted_covariance(i, j) - posterior.block<2, 2>(2 * i, 2 * j)).norm(), 2e-6);
    }
    EXPECT_TRUE(filter.is_sound());
}

TEST(LineSlamEkf, compressed_filter_equals_the_full_one) {
    Drive d;
    Ekf full(d.drive), compressed(d.drive);
    std::vector<int> all;
    for (int step = 0; step < 120; ++step) {
        const WheelTravel travel = d.go();
        full.predict(travel);
        compressed.predict(travel);
        // A few lines at a time: lines 0..k are known.
        const std::size_t wall = static_cast<std::size_t>(step / 15) % d.walls.size();
        const std::vector<LineObservation> z{d.see(wall), d.see((wall + 3) % d.walls.size())};
        if (step % 15 == 0 && all.size() < d.walls.size()) {
            all.push_back(full.augment(z[0]));
            ASSERT_EQ(compressed.augment(z[0]), all.back());
            continue;
        }
        const int id = static_cast<int>(wall);
        if (!compressed.is_active(id) || step % 15 == 7) compressed.activate({id});
        ASSERT_TRUE(full.update({{id, 0}}, z));
        ASSERT_TRUE(compressed.update({{id, 0}}, z));
    }
    EXPECT_GT(compressed.local_maps(), 3u);
    const std::vector<Eigen::Matrix2d> covariances = compressed.line_covariances();
    compressed.refresh_passive_lines();
    for (const int i : all) {
        EXPECT_LT((full.line_covariance(i) - covariances[static_cast<std::size_t>(i)]).norm(), 1e-9)
            << "passive line " << i;
        EXPECT_LT(difference(full.line(i), compressed.line(i)).norm(), 1e-9) << "passive line " << i;
    }
    std::vector<int> backwards(all.rbegin(), all.rend());
    compressed.activate(backwards);
    full.activate(all);
    EXPECT_EQ(compressed.local_maps(), 1u);
    EXPECT_LT((full.pose_covariance() - compressed.pose_covariance()).norm(),
              1e-9 * full.pose_covariance().norm());
    EXPECT_LT((full.T_map_base().translation() - compressed.T_map_base().translation()).norm(), 1e-9);
    for (const int i : all) {
        EXPECT_LT(difference(full.line(i), compressed.line(i)).norm(), 1e-9) << "line " << i;
        for (const int j : all)
            EXPECT_LT((full.predicted_covariance(i, j) - compressed.predicted_covariance(i, j)).norm(), 1e-9);
    }
}

/// Many rooms, left and come back to in any order, lines removed and merged, maps joined: still the full
/// filter.
TEST(LineSlamEkf, chain_of_local_maps_equals_the_full_filter_on_a_long_and_winding_way) {
    Drive d;
    d.walls.clear();
    for (int room = 0; room < 12; ++room)
        for (const auto& w : test::square_ring(20 + room, 10 - 0.5 * room)) d.walls.push_back(w);
    Ekf full(d.drive), chain(d.drive);
    std::vector<int> id_of_wall(d.walls.size(), -1);
    std::size_t most_maps = 0;
    int room = 0;
    for (int step = 0; step < 400; ++step) {
        const WheelTravel travel = d.go();
        full.predict(travel);
        chain.predict(travel);
        if (step % 8 == 7)
            room = std::uniform_int_distribution<int>(0, step < 200 ? step / 17 : 11)(d.random);
        std::vector<LineObservation> z;
        std::vector<Pairing> pairings;
        std::vector<int> near;
        for (std::size_t w = static_cast<std::size_t>(8 * room); w < static_cast<std::size_t>(8 * room + 8);
             ++w) {
            if ((static_cast<int>(w) + step) % 3 == 0) continue;
            z.push_back(d.see(w));
            if (id_of_wall[w] < 0) {
                id_of_wall[w] = full.augment(z.back());
                ASSERT_EQ(chain.augment(z.back()), id_of_wall[w]);
                z.pop_back();
            } else {
                pairings.push_back({id_of_wall[w], static_cast<int>(z.size()) - 1});
            }
            near.push_back(id_of_wall[w]);
        }
        if (step % 2 == 0)
            chain.activate(near);
        else
            chain.activate_also(near);
        most_maps = std::max(most_maps, chain.local_maps());
        ASSERT_TRUE(full.update(pairings, z));
        ASSERT_TRUE(chain.update(pairings, z));
        if (step % 90 == 60) {  // a line of an old room goes
            const auto w = static_cast<std::size_t>(8 * (step / 90) + 2);
            full.remove(id_of_wall[w]);
            chain.remove(id_of_wall[w]);
            id_of_wall[w] = -1;
        }
        if (step % 90 == 70 && near.size() > 1) {
            const Ekf::SameWall same{near[0], near[1], 1e4 * Eigen::Matrix2d::Identity()};
            ASSERT_TRUE(full.merge({same}));
            ASSERT_TRUE(chain.merge({same}));
            std::replace(id_of_wall.begin(), id_of_wall.end(), near[1], -1);
        }
        ASSERT_LT((full.pose_covariance() - chain.pose_covariance()).norm(),
                  1e-9 * full.pose_covariance().norm());
    }
    EXPECT_GT(most_maps, 5u);
    const std::vector<Eigen::Matrix2d> covariances = chain.line_covariances();
    chain.refresh_passive_lines();
    std::vector<int> all;
    for (int id = 0; id < full.line_ids(); ++id) {
        ASSERT_EQ(full.exists(id), chain.exists(id));
        if (!full.exists(id)) continue;
        all.push_back(id);
        EXPECT_LT(difference(full.line(id), chain.line(id)).norm(),
                  1e-9 * (1 + std::abs(full.line(id).rho_m)));
        EXPECT_LT((full.line_covariance(id) - covariances[static_cast<std::size_t>(id)]).norm(), 1e-9);
    }
    chain.activate(all);
    EXPECT_EQ(chain.local_maps(), 1u);
    // What rounding leaves of 400 updates.
    EXPECT_LT((full.T_map_base().translation() - chain.T_map_base().translation()).norm(), 1e-8);
    for (const int i : all)
        for (const int j : all)
            ASSERT_LT((full.predicted_covariance(i, j) - chain.predicted_covariance(i, j)).norm(), 1e-9);
}

/// Lines that were first seen when the heading was uncertain can't tell it, however often they are seen
/// again, and however far from the map's origin.
TEST(LineSlamEkf, new_lines_tell_nothing_of_the_old_frame) {
    Drive d;
    d.T_world_base = {0, 0, 0};
    d.drive.sigma_wheel_m = 0.005;
    d.drive.sigma_scale = 1e-6;  // what is learned of the wheels would tell of the way there too
    Ekf filter(d.drive);
    for (int i = 0; i < 500; ++i) {  // 100 m without any wall
        const WheelTravel travel =
            test::measured(wheel_travel({0.2, 0, 0}, d.drive.track_width_m), d.drive, {}, d.random);
        d.T_world_base = d.T_world_base * Pose2{0.2, 0, 0};
        filter.predict(travel);
    }
    for (auto& w : d.walls) w = {w.from_m + Eigen::Vector2d(100, 0), w.to_m + Eigen::Vector2d(100, 0)};
    const double before = std::sqrt(filter.pose_covariance()(2, 2));
    std::vector<LineObservation> z;
    std::vector<Pairing> pairings;
    for (std::size_t w = 0; w < 8; ++w) {
        filter.augment(d.see(w));
        pairings.push_back({static_cast<int>(w), static_cast<int>(w)});
    }
    for (int i = 0; i < 300; ++i) {
        filter.predict(d.go());
        z.clear();
        for (std::size_t w = 0; w < 8; ++w) z.push_back(d.see(w));
        ASSERT_TRUE(filter.update(pairings, z));
    }
    EXPECT_GT(std::sqrt(filter.pose_covariance()(2, 2)), 0.98 * before);
}

/// The same way, begun at the map's origin and 400 m from it: large corrections of the heading give the same.
TEST(LineSlamEkf, the_place_on_the_map_does_not_matter) {
    DriveParameters drive;
    drive.sigma_wheel_m = 1e-12;  // no error on the way there
    drive.sigma_side_m = drive.sigma_rest_m = drive.sigma_scale = 1e-12;
    Ekf near(drive), far(drive);
    far.predict(wheel_travel({400, 0, 0}, drive.track_width_m));
    const Pose2 T_far_near = far.T_map_base();
    Drive d;
    d.T_world_base = {0, 0, 0};
    const Eigen::Matrix3d Q = Eigen::Vector3d(1e-4, 1e-4, 1e-4).asDiagonal();
    for (int step = 0; step < 60; ++step) {
        const WheelTravel travel = d.go();
        near.predict({{travel, Q}});
        far.predict({{travel, Q}});
        std::vector<LineObservation> z;
        std::vector<Pairing> pairings;
        for (std::size_t w = 0; w < 8; ++w) {
            if ((w < 4) != (step % 30 < 15))
                continue;  // half of them, then the others: corrections are large
            z.push_back(d.see(w));
            if (step == 0 || step == 15) {
                ASSERT_EQ(near.augment(z.back()), far.augment(z.back()));
                continue;
            }
            pairings.push_back({static_cast<int>(w), static_cast<int>(z.size()) - 1});
        }
        ASSERT_TRUE(near.update(pairings, z));
        ASSERT_TRUE(far.update(pairings, z));
        const Pose2 apart = (T_far_near * near.T_map_base()).inverse() * far.T_map_base();
        ASSERT_LT(apart.translation().norm(), 1e-6);
        ASSERT_LT(std::abs(apart.phi_rad), 1e-7);
        ASSERT_LT((near.pose_covariance() - far.pose_covariance()).norm(),
                  1e-5 * near.pose_covariance().norm());
    }
}

TEST(LineSlamEkf, the_papers_sum_of_gains_is_over_confident) {
    Drive d;
    Ekf joint(d.drive), sum(EkfParameters{d.drive, Feature::line, Update::paper_sum});
    for (Ekf* filter : {&joint, &sum}) {
        Drive same;
        filter->predict(same.go());
        std::vector<LineObservation> z{same.see(0), same.see(1), same.see(4)};
        for (const auto& o : z) filter->augment(o);
        filter->predict(same.go());
        // One line alone: no difference.
        const std::vector<LineObservation> one{same.see(0)};
        ASSERT_TRUE(filter->update({{0, 0}}, one));
    }
    EXPECT_LT((joint.pose_covariance() - sum.pose_covariance()).norm(), 1e-15);
    for (Ekf* filter : {&joint, &sum}) {
        Drive same;
        for (int i = 0; i < 3; ++i) filter->predict(same.go());
        const std::vector<LineObservation> z{same.see(0), same.see(1), same.see(4)};
        ASSERT_TRUE(filter->update({{0, 0}, {1, 1}, {2, 2}}, z));
    }
    // Three gains that do not know of one another take more from the covariance than there is to know.
    EXPECT_LT(sum.pose_covariance()(2, 2), joint.pose_covariance()(2, 2));
}

TEST(LineSlamEkf, an_update_with_nonsense_is_refused_and_changes_nothing) {
    Drive d;
    Ekf filter(d.drive);
    filter.predict(d.go());
    std::vector<LineObservation> z{d.see(0)};
    filter.augment(z[0]);
    const Eigen::Matrix3d before = filter.pose_covariance();
    z[0].line.rho_m = std::numeric_limits<double>::quiet_NaN();
    EXPECT_FALSE(filter.update({{0, 0}}, z));
    EXPECT_EQ(before, filter.pose_covariance());
    EXPECT_TRUE(filter.is_sound());
}

TEST(LineSlamEkf, merging_two_lines_of_one_wall_leaves_one_better_line) {
    Drive d;
    Ekf filter(d.drive);
    filter.predict(d.go());
    filter.augment(d.see(0));
    for (int i = 0; i < 10; ++i) filter.predict(d.go());
    filter.augment(d.see(0));
    filter.augment(d.see(1));
    const double before = filter.line_covariance(0)(0, 0), heading = filter.pose_covariance()(2, 2);
    ASSERT_TRUE(filter.merge({{0, 1, 1e-6 * Eigen::Matrix2d::Identity()}}));
    EXPECT_FALSE(filter.exists(1));
    EXPECT_TRUE(filter.exists(2));
    EXPECT_LE(filter.line_covariance(0)(0, 0), before);
    EXPECT_LT(filter.pose_covariance()(2, 2), heading) << "the loop tells the heading";
    EXPECT_TRUE(filter.is_sound());
    filter.remove(2);
    EXPECT_EQ(filter.active_lines(), std::vector<int>{0});
}

}  // namespace
