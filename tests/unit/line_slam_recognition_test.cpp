/// Place recognition: a known displacement is found, an ambiguous one refused. Association: the long wall
/// decides.
#include <gtest/gtest.h>

#include <functional>
#include <random>

#include "api/dense_algebra.h"
#include "least_squares/chi_square.h"
#include "line_slam/association.h"
#include "line_slam/place_recognition.h"

using namespace loopline;
using namespace loopline::line_slam;

namespace {

PlaceLine place_line(int id, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    const Eigen::Vector2d t = (b - a).normalized(), n(t.y(), -t.x());
    const PlanarLine l{n.dot(a), std::atan2(n.y(), n.x())};
    return {id, l, Extent::of(l, a, b)};
}

PlaceLine displaced(int id, const PlaceLine& l, const Pose2& T) {
    const PlanarLine m = transformed(T, l.line);
    return {id, m, Extent::of(m, T * l.line.point_m(l.extent.from_m), T * l.line.point_m(l.extent.to_m))};
}

TEST(LineSlamRecognition, finds_a_known_displacement_in_random_places) {
    std::mt19937_64 random(11);
    std::uniform_real_distribution<double> at(-15, 15), angle(-M_PI, M_PI), length(1.5, 5), shift(-0.4, 0.4),
        turn(-0.08, 0.08);
    int found = 0;
    for (int world = 0; world < 50; ++world) {
        std::vector<PlaceLine> old, recent;
        const Eigen::Vector2d here(at(random) + 50, at(random));
        const Pose2 about{here.x(), here.y(), 0};
        const Pose2 T_old_recent =
            about * Pose2{shift(random), shift(random), turn(random)} * about.inverse();
        for (int i = 0; i < 14; ++i) {
            const Eigen::Vector2d a = here + Eigen::Vector2d(at(random), at(random));
            const double direction = angle(random), l = length(random);
            old.push_back(
                place_line(i, a, a + l * Eigen::Vector2d(std::cos(direction), std::sin(direction))));
            if (i < 9) recent.push_back(displaced(100 + i, old.back(), T_old_recent.inverse()));
        }
        const auto r = recognise_place(recent, old, here, {});
        if (!r) continue;
        ++found;
        const Pose2 error = r->T_old_recent.inverse() * T_old_recent;
        EXPECT_LT((error * here - here).norm(), 1e-6);
        EXPECT_LT(std::abs(error.phi_rad), 1e-6);
        for (const auto& [id_recent, id_old] : r->matches) EXPECT_EQ(id_recent, id_old + 100);
    }
    EXPECT_GE(found, 48);
}

TEST(LineSlamRecognition, a_bare_corridor_is_refused) {
    // Two parallel walls: any displacement along them agrees.
    std::vector<PlaceLine> old{place_line(0, {0, 0}, {20, 0}), place_line(1, {20, 2}, {0, 2})};
    std::vector<PlaceLine> recent{displaced(10, old[0], {0.1, 0.1, 0}), displaced(11, old[1], {0.1, 0.1, 0})};
    EXPECT_FALSE(recognise_place(recent, old, {10, 1}, {}));
    // Doors of one kind at regular distances: two displacements agree equally well.
    for (int i = 0; i < 12; ++i) {
        const double x = 1 + 0.6 * i;
        old.push_back(place_line(20 + i, {x, 0}, {x, 0.6}));
        recent.push_back(displaced(40 + i, old.back(), {0.3, 0, 0}));
    }
    RecognitionParameters p;
    p.max_shift_m = 0.9;
    EXPECT_FALSE(recognise_place(recent, old, {10, 1}, p));
}

TEST(LineSlamAssociation, the_long_wall_decides_and_gaps_separate) {
    DriveParameters drive;
    Ekf filter(drive);
    MapLineRecords records;
    const auto wall = [](double rho_m, double alpha, double from, double to, double sigma_m,
                         double sigma_rad) {
        LineObservation z;
        z.line = {rho_m, alpha};
        z.start_m = z.line.point_m(from);
        z.end_m = z.line.point_m(to);
        z.covariance = Eigen::Vector2d(sigma_m * sigma_m, sigma_rad * sigma_rad).asDiagonal();
        return z;
    };
    const auto add = [&](const LineObservation& z) {
        const int id = filter.augment(z);
        MapLineRecord r;
        r.extent = Extent::of(filter.line(id), z.start_m, z.end_m);
        records.push_back(r);
        return id;
    };
    const int long_wall = add(wall(3, M_PI - 1e-4, -8, 8, 0.005, 0.001));
    const int bush = add(wall(2, 0.5, -0.3, 0.3, 0.005, 0.005));
    filter.predict(WheelTravel{0.3, 0.5, 0});  // turning: the heading is now vague
    const Pose2 truth = filter.T_map_base() * Pose2{0, 0, 0.03};
    const auto seen = [&](const LineObservation& z, const Pose2& T) {
        LineObservation o = z;
        o.line = predicted_line(T, z.line);
        o.start_m = T.inverse() * z.start_m;
        o.end_m = T.inverse() * z.end_m;
        return o;
    };
    // The bush has moved: it says the heading did not change, the wall (across the cut of the angle) that it
    // did.
    std::vector<LineObservation> z{seen(wall(2, 0.40, -0.3, 0.3, 0.005, 0.001), filter.T_map_base()),
                                   seen(wall(3, M_PI - 1e-4, -8, 8, 0.005, 0.001), truth)};
    const Association a = associate(filter, records, z, {});
    ASSERT_EQ(a.pairings.size(), 1u);
    EXPECT_EQ(a.pairings[0].line, long_wall);
    EXPECT_EQ(a.pairings[0].observation, 1);
    EXPECT_NE(a.pairings[0].line, bush);
    // Collinear, but 5 m beyond the seen part.
    z = {seen(wall(3, M_PI - 1e-4, 13, 15, 0.005, 0.001), filter.T_map_base())};
    EXPECT_TRUE(associate(filter, records, z, {}).pairings.empty());
    records[static_cast<std::size_t>(long_wall)].awake = false;
    z = {seen(wall(3, M_PI - 1e-4, -8, 8, 0.005, 0.001), filter.T_map_base())};
    EXPECT_TRUE(associate(filter, records, z, {}).pairings.empty());
}

/// Several walls that are hard to tell apart, seen from an uncertain pose: branch and bound against all sets
/// of pairings.
TEST(LineSlamAssociation, branch_and_bound_finds_what_trying_everything_finds) {
    std::mt19937_64 random(21);
    std::normal_distribution<double> normal;
    int larger_than_nearest = 0;
    for (int world = 0; world < 60; ++world) {
        Ekf filter{DriveParameters{}};
        MapLineRecords records;
        const auto look = [&](double rho_m, double alpha) {
            LineObservation z;
            z.line = {rho_m, alpha};
            z.start_m = z.line.point_m(-2);
            z.end_m = z.line.point_m(2);
            z.covariance = Eigen::Vector2d(1e-4, 1e-4).asDiagonal();
            return z;
        };
        // Pairs of parallel walls, 6 cm apart, in three directions.
        std::vector<PlanarLine> walls;
        for (int i = 0; i < 6; ++i) walls.push_back({3 + 0.06 * (i % 2), 2.0 * (i / 2)});
        for (const PlanarLine& w : walls) {
            const int id = filter.augment(look(w.rho_m, w.alpha_rad));
            records.push_back({{-2, 2}, id, 3, 0, {0}});
        }
        filter.predict(WheelTravel{1.5, 1.5, 0});
        const Pose2 truth =
            filter.T_map_base() * Pose2{0.05 * normal(random), 0.05 * normal(random), 0.02 * normal(random)};
        std::vector<LineObservation> z;
        for (const PlanarLine& w : walls) {
            LineObservation o = look(0, 0);
            o.line = predicted_line(truth, w);
            o.line.rho_m += 0.01 * normal(random);
            o.line.alpha_rad += 0.01 * normal(random);
            const double shift_m = w.along_m(truth.translation());
            o.start_m = o.line.point_m(-2 - shift_m);
            o.end_m = o.line.point_m(2 - shift_m);
            if (random() % 3 != 0) z.push_back(o);
        }
        AssociationParameters p;
        p.method = AssociationMethod::jcbb;
        const Association found = associate(filter, records, z, p);

        // Joint distance of a set of pairings, straight from the definition.
        const auto distance2 = [&](const std::vector<Pairing>& set) {
            const auto m = 2 * static_cast<Eigen::Index>(set.size());
            Eigen::MatrixXd S(m, m);
            Eigen::VectorXd v(m);
            for (std::size_t i = 0; i < set.size(); ++i) {
                const LineObservation& o = z[static_cast<std::size_t>(set[i].observation)];
                const auto at = 2 * static_cast<Eigen::Index>(i);
                v.segment<2>(at) =
                    innovation(o.line, predicted_line(filter.T_map_base(), filter.line(set[i].line)));
                for (std::size_t j = 0; j < set.size(); ++j)
                    S.block<2, 2>(at, 2 * static_cast<Eigen::Index>(j)) =
                        filter.predicted_covariance(set[i].line, set[j].line);
                S.block<2, 2>(at, at) += o.covariance;
            }
            return m == 0 ? 0.0 : squared_in_sigmas(v, S);
        };
        std::size_t best_size = 0;
        double best_distance2 = 0;
        std::vector<Pairing> set;
        const std::function<void(std::size_t)> all = [&](std::size_t i) {
            if (i == z.size()) {
                const double d2 = distance2(set);
                if (d2 >= least_squares::chi_square_quantile(
                              2.0 * static_cast<double>(std::max<std::size_t>(set.size(), 1)), p.probability))
                    return;
                if (set.size() > best_size || (set.size() == best_size && d2 < best_distance2)) {
                    best_size = set.size();
                    best_distance2 = d2;
                }
                return;
            }
            for (int id = 0; id < 6; ++id) {
                set.push_back({id, static_cast<int>(i)});
                if (distance2({set.back()}) < p.gate &&
                    overlap_m(filter.T_map_base(), filter.line(id),
                              records[static_cast<std::size_t>(id)].extent, z[i]) > -p.max_gap_m)
                    all(i + 1);
                set.pop_back();
            }
            all(i + 1);
        };
        all(0);
        EXPECT_EQ(found.pairings.size(), best_size) << "world " << world;
        EXPECT_NEAR(distance2(found.pairings), best_distance2, 1e-6) << "world " << world;
        p.method = AssociationMethod::nearest;
        const Association by_itself = associate(filter, records, z, p);
        int wrong = 0;
        for (const Pairing& q : by_itself.pairings) wrong += distance2({q}) >= p.gate;
        EXPECT_EQ(wrong, 0);
        larger_than_nearest += distance2(by_itself.pairings) > best_distance2 + 10;
    }
    EXPECT_GT(larger_than_nearest, 5) << "the worlds are too easy to tell the methods apart";
}

}  // namespace
