#include "gnss/transverse_mercator.h"

#include <array>
#include <cmath>

#include "gnss/geodetic.h"

namespace loopline::gnss {
namespace {

using Series = std::array<double, 6>;  // coefficients of sin(2 j x), j = 1 .. 6

constexpr double n = wgs84::n, n2 = n * n, n3 = n2 * n, n4 = n3 * n, n5 = n4 * n, n6 = n5 * n;

/// Radius of the circle that is as long as a meridian.
constexpr double rectifying_radius_m = wgs84::a_m / (1 + n) * (1 + n2 / 4 + n4 / 64 + n6 / 256);

/// Conformal sphere to Gauss-Krueger: Karney 2011, eq. (35).
constexpr Series alpha{n / 2 - 2 * n2 / 3 + 5 * n3 / 16 + 41 * n4 / 180 - 127 * n5 / 288 + 7891 * n6 / 37800,
                       13 * n2 / 48 - 3 * n3 / 5 + 557 * n4 / 1440 + 281 * n5 / 630 - 1983433 * n6 / 1935360,
                       61 * n3 / 240 - 103 * n4 / 140 + 15061 * n5 / 26880 + 167603 * n6 / 181440,
                       49561 * n4 / 161280 - 179 * n5 / 168 + 6601661 * n6 / 7257600,
                       34729 * n5 / 80640 - 3418889 * n6 / 1995840,
                       212378941 * n6 / 319334400};

/// And back: eq. (36).
constexpr Series beta{n / 2 - 2 * n2 / 3 + 37 * n3 / 96 - n4 / 360 - 81 * n5 / 512 + 96199 * n6 / 604800,
                      n2 / 48 + n3 / 15 - 437 * n4 / 1440 + 46 * n5 / 105 - 1118711 * n6 / 3870720,
                      17 * n3 / 480 - 37 * n4 / 840 - 209 * n5 / 4480 + 5569 * n6 / 90720,
                      4397 * n4 / 161280 - 11 * n5 / 504 - 830251 * n6 / 7257600,
                      4583 * n5 / 161280 - 108847 * n6 / 3991680,
                      20648693 * n6 / 638668800};

/// Conformal to geodetic latitude: Kawase's delta.
constexpr Series delta{2 * n - 2 * n2 / 3 - 2 * n3 + 116 * n4 / 45 + 26 * n5 / 45 - 2854 * n6 / 675,
                       7 * n2 / 3 - 8 * n3 / 5 - 227 * n4 / 45 + 2704 * n5 / 315 + 2323 * n6 / 945,
                       56 * n3 / 15 - 136 * n4 / 35 - 1262 * n5 / 105 + 73814 * n6 / 2835,
                       4279 * n4 / 630 - 332 * n5 / 35 - 399572 * n6 / 14175,
                       4174 * n5 / 315 - 144838 * n6 / 6237,
                       601676 * n6 / 22275};

}  // namespace

TransverseMercator project(double latitude_deg, double longitude_deg) {
    const double phi = latitude_deg * rad_per_deg, lambda = longitude_deg * rad_per_deg;
    const double e = std::sqrt(wgs84::e2);
    // asinh(tan phi) is atanh(sin phi), and keeps its digits near the poles.
    const double t = std::sinh(std::asinh(std::tan(phi)) - e * std::atanh(e * std::sin(phi)));
    const double secant = std::hypot(1, t);
    const double xi = std::atan2(t, std::cos(lambda)), eta = std::atanh(std::sin(lambda) / secant);

    double xi_sum = xi, eta_sum = eta, sigma = 1, tau = 0;
    for (int j = 1; j <= 6; ++j) {
        const double a = alpha[static_cast<std::size_t>(j - 1)];
        const double s = std::sin(2 * j * xi), c = std::cos(2 * j * xi);
        const double sh = std::sinh(2 * j * eta), ch = std::cosh(2 * j * eta);
        xi_sum += a * s * ch;
        eta_sum += a * c * sh;
        sigma += 2 * j * a * c * ch;
        tau += 2 * j * a * s * sh;
    }

    TransverseMercator grid;
    grid.east_m = rectifying_radius_m * eta_sum;
    grid.north_m = rectifying_radius_m * xi_sum;
    const double sin_lambda = std::sin(lambda), cos_lambda = std::cos(lambda);
    grid.convergence_rad = std::atan2(tau * secant * cos_lambda + sigma * t * sin_lambda,
                                      sigma * secant * cos_lambda - tau * t * sin_lambda);
    const double flattened = (1 - n) / (1 + n) * std::tan(phi);
    grid.scale = rectifying_radius_m / wgs84::a_m *
                 std::sqrt((1 + flattened * flattened) * (sigma * sigma + tau * tau) /
                           (t * t + cos_lambda * cos_lambda));
    return grid;
}

PlaceBesideMeridian unproject(double east_m, double north_m) {
    const double xi = north_m / rectifying_radius_m, eta = east_m / rectifying_radius_m;
    double xi_sphere = xi, eta_sphere = eta;
    for (int j = 1; j <= 6; ++j) {
        const double b = beta[static_cast<std::size_t>(j - 1)];
        xi_sphere -= b * std::sin(2 * j * xi) * std::cosh(2 * j * eta);
        eta_sphere -= b * std::cos(2 * j * xi) * std::sinh(2 * j * eta);
    }
    // asin(sin xi' / cosh eta'), without the digits that an arc sine loses near the poles.
    const double conformal =
        std::atan2(std::sin(xi_sphere), std::hypot(std::sinh(eta_sphere), std::cos(xi_sphere)));
    double phi = conformal;
    for (int j = 1; j <= 6; ++j) phi += delta[static_cast<std::size_t>(j - 1)] * std::sin(2 * j * conformal);
    const double lambda = std::atan2(std::sinh(eta_sphere), std::cos(xi_sphere));
    return {phi / rad_per_deg, lambda / rad_per_deg};
}

}  // namespace loopline::gnss
