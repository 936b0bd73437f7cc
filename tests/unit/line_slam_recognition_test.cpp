/// Place recognition: a known displacement is found, an ambiguous one refused. Association: the long wall
/// decides.
#include <gtest/gtest.h>

#include <random>

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

}  // namespace
