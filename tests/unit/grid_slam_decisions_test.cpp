/// Loops that people name, refuse, or do not want to be looked for.
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <stdexcept>

#include "grid_slam/grid_slam.h"
#include "grid_slam/loop_decisions.h"
#include "support/grid_slam_drive.h"

using namespace loopline;
using namespace loopline::grid_slam;

namespace decisions_of_people {

using Decision = LoopRecord::Decision;
constexpr StampNs tenth_ns = 100'000'000, start_ns = StampNs{1'600'000'000} * 10 * tenth_ns;

/// Once around the block and a part of the way again.
struct Ring {
    std::vector<Pose2> truth =
        test::drive_along({{0, 0}, {12, 0}, {12, 8}, {0, 8}, {0, 0}, {11, 0}}, 0.1, 5 * M_PI / 180);

    static StampNs stamp(std::size_t scan) { return start_ns + static_cast<StampNs>(scan) * tenth_ns; }
    /// The first scan from one on that is near a place.
    std::size_t scan_at(double x_m, double y_m, std::size_t from = 0) const {
        while ((truth[from].translation() - Eigen::Vector2d(x_m, y_m)).norm() > 0.06) ++from;
        return from;
    }
    std::string name(std::size_t later, std::size_t earlier) const {
        return seconds_text(stamp(later)) + " - " + seconds_text(stamp(earlier));
    }

    /// Halfway the wheels tell `slip_m` of way too much, which their covariance knows nothing of.
    std::unique_ptr<GridSlam> run(const DecisionSettings& decisions, double slip_m = 0) const {
        std::mt19937_64 random(1);
        const auto world = test::ring_building();
        const grid_map_world::Sensor sensor{271, 1.5 * M_PI, {0.2, 0, 0}, 0.01, 20};
        auto motions = test::noisy_motions(truth, {0.01, 0.01, 0.3 * M_PI / 180}, random);
        motions[scan_at(6, 8)].T_before_now.x_m += slip_m;
        GridSlamSettings settings;
        settings.decisions = decisions;
        settings.active.sigma_m = 0.05;  // what is behind is soon too uncertain to match with
        auto owned = std::make_unique<GridSlam>(settings);
        test::map_drive(*owned, world, truth, motions, sensor, stamp, random);
        return owned;
    }
    double rmse_m(const GridSlam& slam) const {
        std::vector<Pose2> poses;
        std::vector<Eigen::Matrix3d> covariances;
        slam.path(poses, covariances);
        double squares = 0;
        for (std::size_t k = 0; k < truth.size(); ++k)
            squares += (poses[k].translation() - (truth[0].inverse() * truth[k]).translation()).squaredNorm();
        return std::sqrt(squares / static_cast<double>(truth.size()));
    }
};

std::size_t accepted(const GridSlam& slam) {
    return static_cast<std::size_t>(
        std::count_if(slam.loops().begin(), slam.loops().end(),
                      [](const LoopRecord& r) { return r.decision == Decision::accepted; }));
}

std::string complaint(const std::function<void()>& read) {
    try {
        read();
    } catch (const std::invalid_argument& e) {
        return e.what();
    }
    return "none";
}

TEST(LoopDecisions, are_read_as_a_surveyor_writes_them) {
    const auto named = named_loops_from_text("1118420800.12 - 1118420100.5,1118420900-1118420000.000000001");
    ASSERT_EQ(named.size(), 2U);
    EXPECT_EQ(named[0].stamp_ns, 1118420800'120'000'000);
    EXPECT_EQ(named[0].old_stamp_ns, 1118420100'500'000'000);
    EXPECT_EQ(named[1].old_stamp_ns, 1118420000'000'000'001);
    const auto refused = refusals_from_text(" 30 - 10 , 50, 60 .. 70 ");
    ASSERT_EQ(refused.size(), 3U);
    EXPECT_EQ(refused[0].old_stamp_ns, 10'000'000'000);
    EXPECT_FALSE(refused[0].to_ns || refused[1].to_ns || refused[1].old_stamp_ns);
    EXPECT_EQ(refused[2].to_ns, 70'000'000'000);
    EXPECT_TRUE(refusals_from_text("").empty());
    EXPECT_TRUE(named_loops_from_text(" ").empty());
}

TEST(LoopDecisions, what_can_not_be_meant_is_told) {
    EXPECT_EQ(complaint([] { named_loops_from_text("10 - 30"); }),
              "holds \"10 - 30\": the later scan comes first (an interval is \"from .. to\")");
    EXPECT_EQ(complaint([] { named_loops_from_text("30 - 10, 40"); }),
              "holds \"40\"; a loop is \"later - earlier\", in seconds");
    EXPECT_EQ(complaint([] { named_loops_from_text("30 - noon"); }),
              "holds \"30 - noon\", where \"noon\" is not a time in seconds");
    EXPECT_EQ(complaint([] { refusals_from_text("70 .. 60"); }),
              "holds \"70 .. 60\", which ends before it begins");
    EXPECT_EQ(complaint([] { refusals_from_text("30 - 10 - 5"); }),
              "holds \"30 - 10 - 5\", where \"10 - 5\" is not a time in seconds");
    EXPECT_EQ(complaint([] { intervals_from_text("60"); }),
              "holds \"60\"; an interval is \"from .. to\", in seconds");
}

TEST(LoopDecisions, differ_only_from_where_they_begin_to) {
    const auto alike = [](const char* a, const char* b, double loop_s) {
        return refuse_alike_before(refusals_from_text(a), refusals_from_text(b),
                                   static_cast<StampNs>(loop_s * 1e9));
    };
    EXPECT_TRUE(alike("", "", 0));
    EXPECT_TRUE(alike("", "30 - 10", 30)) << "what is refused is the loop at hand itself";
    EXPECT_TRUE(alike("30 - 10", "", 29));
    EXPECT_FALSE(alike("", "30 - 10", 31));
    EXPECT_TRUE(alike("30 - 10, 50", "50.0, 30 - 10", 60));
    EXPECT_FALSE(alike("30 - 10", "30 - 11", 60));
    EXPECT_FALSE(alike("30", "30 .. 40", 60));
}

TEST(LoopDecisions, a_named_loop_is_closed_where_the_search_is_off) {
    const Ring ring;
    const std::size_t earlier = ring.scan_at(5, 0), later = ring.scan_at(5, 0, ring.truth.size() - 80);
    DecisionSettings off;
    off.without_search = intervals_from_text("0 .. 9000000000");
    const auto without_run = ring.run(off);
    const GridSlam& without = *without_run;
    EXPECT_TRUE(without.loops().empty());

    DecisionSettings decisions = off;
    decisions.named = named_loops_from_text(ring.name(later, earlier));
    const auto with_run = ring.run(decisions);
    const GridSlam& with = *with_run;
    ASSERT_EQ(with.loops().size(), 1U);
    const LoopRecord& loop = with.loops()[0];
    EXPECT_EQ(loop.decision, Decision::accepted) << loop.reason;
    EXPECT_EQ(loop.reason, "named in the .ini");
    EXPECT_EQ(with.map().stamps_ns[loop.frame], Ring::stamp(later)) << "that very scan is in the map";
    EXPECT_LT(std::abs(with.map().stamps_ns[loop.old_frame] - Ring::stamp(earlier)), 3 * tenth_ns);
    EXPECT_LT(ring.rmse_m(with), 0.02);
    EXPECT_LT(ring.rmse_m(with), ring.rmse_m(without));
    EXPECT_TRUE(with.decisions().untried().empty());
}

TEST(LoopDecisions, a_named_loop_is_closed_that_is_farther_off_than_what_is_uncertain) {
    const Ring ring;
    const std::size_t earlier = ring.scan_at(5, 0), later = ring.scan_at(5, 0, ring.truth.size() - 80);
    DecisionSettings decisions;
    EXPECT_EQ(accepted(*ring.run(decisions, 3)), 0U) << "it is not found by itself";
    decisions.named = named_loops_from_text(ring.name(later, earlier));
    for (const double slip_m : {3.0, -2.0}) {
        const auto run = ring.run(decisions, slip_m);
        const auto named = std::find_if(run->loops().begin(), run->loops().end(),
                                        [](const LoopRecord& r) { return r.reason == "named in the .ini"; });
        ASSERT_NE(named, run->loops().end()) << slip_m;
        EXPECT_GT(named->shift.head<2>().norm(), 1.5);
        EXPECT_LT(3 * named->sigma_m, 1.5) << "nobody would have searched so far";
        const Pose2 T_old_new = run->map().poses[named->old_frame].inverse() * run->map().poses[named->frame];
        const Pose2 T_true = ring.truth[earlier].inverse() * ring.truth[later];
        EXPECT_LT((T_old_new.translation() - T_true.translation()).norm(), 0.3);
    }
}

TEST(LoopDecisions, a_named_loop_between_two_places_is_refused_with_its_reason) {
    const Ring ring;
    DecisionSettings decisions;
    decisions.named = named_loops_from_text(ring.name(ring.scan_at(6, 8), ring.scan_at(6, 0)));
    const auto slam_run = ring.run(decisions);
    const GridSlam& slam = *slam_run;
    ASSERT_FALSE(slam.loops().empty());
    const LoopRecord& loop = slam.loops()[0];
    EXPECT_EQ(loop.decision, Decision::refused);
    EXPECT_FALSE(loop.reason.empty());
    ASSERT_NE(slam.decisions().name_of(0), nullptr);
    EXPECT_EQ(slam.decisions().name_of(0)->text, ring.name(ring.scan_at(6, 8), ring.scan_at(6, 0)));
    EXPECT_GE(accepted(slam), 1U) << "the true loop is found all the same";
    EXPECT_LT(ring.rmse_m(slam), 0.02);
}

TEST(LoopDecisions, a_named_place_that_is_matched_with_anyway_is_told_so) {
    const Ring ring;
    DecisionSettings decisions;
    decisions.named = named_loops_from_text(ring.name(ring.scan_at(4, 0), ring.scan_at(2, 0)));
    const auto slam_run = ring.run(decisions);
    const GridSlam& slam = *slam_run;
    ASSERT_FALSE(slam.loops().empty());
    EXPECT_EQ(slam.loops()[0].reason, "that place is in the map at hand already");
}

TEST(LoopDecisions, what_the_log_does_not_have_is_told) {
    const Ring ring;
    DecisionSettings decisions;
    decisions.named = named_loops_from_text("40 - 10, 1600000040 - 1599990000, 1700000000 - 1600000010");
    decisions.refused = refusals_from_text("40 - 10, 1600000045, 0 .. 1600000020, 1700000000");
    decisions.without_search = intervals_from_text("20 .. 30");
    const auto slam_run = ring.run(decisions);
    const GridSlam& slam = *slam_run;
    EXPECT_EQ(slam.decisions().untried().size(), 3U);
    for (const auto& [loop, reason] : slam.decisions().untried())
        EXPECT_EQ(reason, "no scan of the log is of that time") << loop->text;
    std::string outside;
    for (const Refusal* refusal : slam.decisions().outside()) outside += refusal->text + "; ";
    EXPECT_EQ(outside, "40 - 10; 1700000000; 20 .. 30; ");
    EXPECT_GE(accepted(slam), 1U);
}

TEST(LoopDecisions, refused_loops_stay_out) {
    const Ring ring;
    const auto free_run = ring.run({});
    const GridSlam& free = *free_run;
    const auto first = std::find_if(free.loops().begin(), free.loops().end(),
                                    [](const LoopRecord& r) { return r.decision == Decision::accepted; });
    ASSERT_NE(first, free.loops().end());
    const auto number = static_cast<std::size_t>(first - free.loops().begin());
    const StampNs at_ns = free.map().stamps_ns[first->frame], old_ns = free.map().stamps_ns[first->old_frame];
    for (const std::string& text : {seconds_text(at_ns) + " - " + seconds_text(old_ns), seconds_text(at_ns),
                                    seconds_text(at_ns) + " .. 9000000000"}) {
        DecisionSettings decisions;
        decisions.refused = refusals_from_text(text);
        const auto slam_run = ring.run(decisions);
        const GridSlam& slam = *slam_run;
        ASSERT_GT(slam.loops().size(), number) << text;
        for (std::size_t i = 0; i < number; ++i)
            EXPECT_EQ(slam.loops()[i].reason, free.loops()[i].reason) << "nothing differs before it";
        EXPECT_EQ(slam.loops()[number].frame, first->frame);
        EXPECT_EQ(slam.loops()[number].reason, "refused by the .ini") << text;
        const double way_m = slam.map().path_m[first->frame];
        for (const LoopRecord& loop : slam.loops())
            EXPECT_FALSE(loop.decision == Decision::accepted && slam.map().path_m[loop.frame] < way_m + 10)
                << text;
    }
    DecisionSettings elsewhere;
    elsewhere.refused = refusals_from_text(ring.name(ring.scan_at(0.5, 0, 400), ring.scan_at(12, 4)));
    EXPECT_GE(accepted(*ring.run(elsewhere)), 1U) << "another place is not refused";
}

}  // namespace decisions_of_people
