#include "lidar_odometry/features.h"

#include <algorithm>
#include <cmath>

namespace loopline::lidar_odometry {
namespace {

constexpr std::uint8_t no_edge = 1, no_plane = 2, neither = 3;
constexpr std::size_t half = FeatureFinder::half_window;
constexpr auto neighbour_count = static_cast<float>(2 * half);  ///< |S| of eq. (1)

/// Beside which a return is not that of the next beam: two beams may be lost.
constexpr float beams_apart = 3.5f;
/// A surface is nearly parallel to the beam if returns lie so many times farther apart than on one that
/// is met square.
constexpr float parallel_stretch = 8;
constexpr float least_step_m = 0.3f;  ///< between a border and what it hides
/// Of the displacement from the neighbours' mean, relative to the width of the neighbourhood.
constexpr float bent = 0.1f, straight = 0.05f;
/// And relative to the noise of ranges.
constexpr float bent_sigmas = 5, straight_sigmas = 3;
constexpr std::size_t fewest_in_group = 5;
/// Of the returns of a planar point from their line.
constexpr float crooked_sigmas = 1.6f;

float sine_between(const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
    return std::sqrt(a.cross(b).squaredNorm() / (a.squaredNorm() * b.squaredNorm()));
}

/// That of half of the neighbouring returns; beams that are lost are fewer.
float typical_step_rad(const std::vector<float>& x_m, const std::vector<float>& y_m,
                       const std::vector<float>& z_m) {
    std::vector<float> steps;
    for (std::size_t i = 0; i + 1 < x_m.size(); i += 7)
        steps.push_back(sine_between({x_m[i], y_m[i], z_m[i]}, {x_m[i + 1], y_m[i + 1], z_m[i + 1]}));
    if (steps.empty()) return 0;
    const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
    std::nth_element(steps.begin(), middle, steps.end());
    return *middle;
}

/// Sums of 2 `half` + 1 neighbours; those at the ends of a ring have none.
void window_sums(const std::vector<float>& values, std::vector<float>& sums) {
    const std::size_t n = values.size();
    sums.assign(n, 0);
    const float* const v = values.data();
    float* const s = sums.data();
    for (std::size_t i = half; i + half < n; ++i) {
        float sum = 0;
        for (std::size_t k = 0; k <= 2 * half; ++k) sum += v[i + k - half];
        s[i] = sum;
    }
}

}  // namespace

void FeatureFinder::Ring::clear() {
    for (auto* values : {&x_m, &y_m, &z_m, &time_s, &range_m}) values->clear();
}

void FeatureFinder::find(const lidar::SpinningScan& scan, const FeatureSettings& settings,
                         SweepFeatures& features) {
    features.edges.clear();
    features.planar.clear();
    R_base_lidar_ = scan.T_base_lidar.rotation.toRotationMatrix().cast<float>();
    t_base_lidar_m_ = scan.T_base_lidar.translation_m.cast<float>();
    middle_s_ = static_cast<float>((scan.begin_s + scan.end_s) / 2);
    for (std::size_t r = 0; r < scan.rings(); ++r) {
        take_ring(scan, r, settings);
        if (ring_.size() <= 2 * half) continue;
        find_curvature();
        find_unfit();
        const auto ring = static_cast<std::uint16_t>(r);
        choose_edges(ring, settings, features.edges);
        choose_planar(ring, settings, features.planar);
    }
}

/// Eq. (7): what is outside of the gate is left out.
void FeatureFinder::take_ring(const lidar::SpinningScan& scan, std::size_t ring,
                              const FeatureSettings& settings) {
    const auto least_m = static_cast<float>(settings.min_range_m),
               most_m = static_cast<float>(settings.max_range_m);
    ring_.clear();
    hidden_.clear();
    for (std::uint32_t i = scan.ring_begin[ring]; i < scan.ring_begin[ring + 1]; ++i) {
        const lidar::SpinningPoint& p = scan.points[i];
        const float range_m = std::sqrt(p.x_m * p.x_m + p.y_m * p.y_m + p.z_m * p.z_m);
        if (!(range_m > least_m)) {
            if (!hidden_.empty()) hidden_.back() = 1;
            continue;
        }
        if (!(range_m < most_m)) continue;
        ring_.x_m.push_back(p.x_m);
        ring_.y_m.push_back(p.y_m);
        ring_.z_m.push_back(p.z_m);
        ring_.time_s.push_back(p.time_s - middle_s_);
        ring_.range_m.push_back(range_m);
        hidden_.push_back(0);
    }
}

/// c = |sum over j of S of (X_i - X_j)| / (|S| |X_i|), eq. (1).
void FeatureFinder::find_curvature() {
    const std::size_t n = ring_.size();
    std::vector<float>&c = ring_.curvature, &w = ring_.width_m;
    c.assign(n, 0);
    w.assign(n, 0);
    std::vector<float> sum_x, sum_y, sum_z;
    window_sums(ring_.x_m, sum_x);
    window_sums(ring_.y_m, sum_y);
    window_sums(ring_.z_m, sum_z);
    const float *x = ring_.x_m.data(), *y = ring_.y_m.data(), *z = ring_.z_m.data();
    for (std::size_t i = half; i + half < n; ++i) {
        const float dx = (neighbour_count + 1) * x[i] - sum_x[i],
                    dy = (neighbour_count + 1) * y[i] - sum_y[i],
                    dz = (neighbour_count + 1) * z[i] - sum_z[i];
        c[i] = std::sqrt(dx * dx + dy * dy + dz * dz) / (neighbour_count * ring_.range_m[i]);
        const float wx = x[i + half] - x[i - half], wy = y[i + half] - y[i - half],
                    wz = z[i + half] - z[i - half];
        w[i] = std::sqrt(wx * wx + wy * wy + wz * wz);
    }
}

void FeatureFinder::mark(std::size_t begin, std::size_t end, std::uint8_t what) {
    for (std::size_t i = begin; i < std::min(end, ring_.size()); ++i)
        ring_.unfit[i] = static_cast<std::uint8_t>(ring_.unfit[i] | what);
}

/// LOAM, section V.A and fig. 4: no points on surfaces nearly parallel to the beam, and none on the border of
/// what something nearer hides.
void FeatureFinder::find_unfit() {
    const std::size_t n = ring_.size();
    beam_step_rad_ = typical_step_rad(ring_.x_m, ring_.y_m, ring_.z_m);
    ring_.open.assign(n, 0);
    ring_.unfit.assign(n, 0);
    mark(0, half, neither);
    mark(n - half, n, neither);
    const float apart_rad = beams_apart * beam_step_rad_, stretched_rad = parallel_stretch * beam_step_rad_;
    bool stretched_before = false;
    for (std::size_t i = 0; i + 1 < n; ++i) {
        const Eigen::Vector3f a = ring_.point(i), b = ring_.point(i + 1);
        const float range_a_m = ring_.range_m[i], range_b_m = ring_.range_m[i + 1],
                    near_m = std::min(range_a_m, range_b_m);
        const std::size_t before = i + 1 >= half ? i + 1 - half : 0;
        if (hidden_[i] != 0) mark(before, i + 1 + half, neither);
        const float apart_m2 = apart_rad * range_a_m * range_b_m;
        if (a.cross(b).squaredNorm() > apart_m2 * apart_m2) {
            ring_.open[i] = 1;
            mark(before, i + 1 + half, no_plane);
            stretched_before = false;
            continue;
        }
        const float stretched_m = stretched_rad * near_m;
        const bool stretched = (b - a).squaredNorm() > stretched_m * stretched_m;
        if (stretched && stretched_before) mark(i, i + 1, neither);
        stretched_before = stretched;
        const float step_m = range_b_m - range_a_m;
        if (std::abs(step_m) < std::max(least_step_m, stretched_m)) continue;
        mark(before, i + 1 + half, no_plane);
        ring_.open[i] = 1;
        if (step_m > 0)
            mark(i + 1, i + 1 + half, neither);
        else
            mark(before, i + 1, neither);
    }
}

Feature FeatureFinder::feature_at(const Eigen::Vector3f& p_lidar_m, float time_s, std::uint16_t ring) const {
    Feature feature;
    feature.p_base_m = R_base_lidar_ * p_lidar_m + t_base_lidar_m_;
    feature.time_s = time_s;
    feature.ring = ring;
    return feature;
}

/// A surface that ends does so anywhere between its last beam and the next: half a step farther on the mean.
/// Without that half, edges seen at a grazing angle would come nearer as the vehicle does, and motion would
/// seem too short.
Feature FeatureFinder::edge_at(std::size_t i, std::uint16_t ring, const FeatureSettings& settings) const {
    const bool ends = ring_.open[i] != 0, begins = ring_.open[i - 1] != 0;
    const std::size_t inner = ends ? i - 2 : i + 2;
    const bool alone = ends == begins || ring_.open[ends ? i - 2 : i + 1] != 0;
    const Eigen::Vector3f p = ring_.point(i);
    Eigen::Vector3f step_m = Eigen::Vector3f::Zero();
    if (!alone) step_m = (p - ring_.point(inner)) / 2;
    Feature edge = feature_at(p + step_m / 2, ring_.time_s[i], ring);
    const float across_m = beam_step_rad_ * ring_.range_m[i],
                between_m2 = std::max(step_m.squaredNorm(), across_m * across_m);
    const double sigma2_m2 =
        settings.sigma_range_m * settings.sigma_range_m + settings.sigma_edge_m * settings.sigma_edge_m;
    edge.variance_m2 = static_cast<float>(sigma2_m2) + between_m2 / (ends == begins ? 3 : 12);
    return edge;
}

/// In each sector the returns with the largest curvature, none beside another.
void FeatureFinder::choose_edges(std::uint16_t ring, const FeatureSettings& settings,
                                 std::vector<Feature>& edges) {
    const auto sectors = static_cast<std::size_t>(settings.sectors);
    const auto least = static_cast<float>(settings.min_edge_curvature),
               noise_m = static_cast<float>(settings.sigma_range_m) * std::sqrt(1 + 1 / neighbour_count);
    for (std::size_t sector = 0; sector < sectors; ++sector) {
        candidates_.clear();
        for (std::size_t i = sector * ring_.size() / sectors; i < (sector + 1) * ring_.size() / sectors;
             ++i) {
            const float c = ring_.curvature[i], off_m = c * ring_.range_m[i];
            if ((ring_.unfit[i] & no_edge) == 0 && c > least && off_m > bent_sigmas * noise_m &&
                off_m > bent * ring_.width_m[i])
                candidates_.push_back(i);
        }
        std::sort(candidates_.begin(), candidates_.end(), [this](std::size_t a, std::size_t b) {
            return ring_.curvature[a] > ring_.curvature[b] ||
                   (ring_.curvature[a] == ring_.curvature[b] && a < b);
        });
        int chosen = 0;
        for (const std::size_t i : candidates_) {
            if (chosen >= settings.edges_kept_per_sector) break;
            if ((ring_.unfit[i] & no_edge) != 0) continue;
            Feature edge = edge_at(i, ring, settings);
            edge.matched = chosen < settings.edges_per_sector ? 1 : 0;
            edges.push_back(edge);
            mark(i >= half ? i - half : 0, i + half + 1, neither);
            ++chosen;
        }
    }
}

/// Runs of returns whose neighbourhood is straight, each as long as planar points lie apart.
void FeatureFinder::find_groups(std::size_t begin, std::size_t end, const FeatureSettings& settings) {
    const auto spacing_m = static_cast<float>(settings.planar_spacing_m),
               noise_m = static_cast<float>(settings.sigma_range_m) * std::sqrt(1 + 1 / neighbour_count);
    groups_.clear();
    Group group;
    group.begin = group.end = begin;
    for (std::size_t i = begin; i < end; ++i) {
        const float off_m = ring_.curvature[i] * ring_.range_m[i];
        const bool planar = (ring_.unfit[i] & no_plane) == 0 &&
                            off_m < std::max(straight * ring_.width_m[i], straight_sigmas * noise_m);
        if (!planar) {
            group = {i + 1, i + 1, 0};
            continue;
        }
        group.end = i + 1;
        group.curvature += ring_.curvature[i];
        const std::size_t count = group.end - group.begin;
        if (count < fewest_in_group || (ring_.point(i) - ring_.point(group.begin)).norm() < spacing_m)
            continue;
        group.curvature /= static_cast<float>(count);
        groups_.push_back(group);
        group = {i + 1, i + 1, 0};
    }
}

std::optional<Feature> FeatureFinder::mean_of(const Group& group, std::uint16_t ring,
                                              const FeatureSettings& settings) const {
    const auto count = static_cast<float>(group.end - group.begin);
    const Eigen::Vector3f first_m = ring_.point(group.begin);  // sums stay small around it
    Eigen::Vector3f sum = Eigen::Vector3f::Zero(), along = Eigen::Vector3f::Zero();
    float time_s = 0, squares = 0;
    for (std::size_t i = group.begin; i < group.end; ++i) {
        const Eigen::Vector3f p = ring_.point(i) - first_m;
        sum += p;
        along += (static_cast<float>(i - group.begin) - (count - 1) / 2) * p;
        squares += p.squaredNorm();
        time_s += ring_.time_s[i];
    }
    const Eigen::Vector3f mean = sum / count;
    along.normalize();
    float across2 = squares - count * mean.squaredNorm();
    for (std::size_t i = group.begin; i < group.end; ++i) {
        const float s = along.dot(ring_.point(i) - first_m - mean);
        across2 -= s * s;
    }
    const auto sigma2 = static_cast<float>(settings.sigma_range_m * settings.sigma_range_m);
    if (across2 > crooked_sigmas * crooked_sigmas * sigma2 * count) return std::nullopt;
    Feature feature = feature_at(first_m + mean, time_s / count, ring);
    feature.along_base = R_base_lidar_ * along;
    feature.beam_base = R_base_lidar_ * (first_m + mean).normalized();
    feature.variance_m2 = sigma2 / count;
    feature.roughness_m2 = static_cast<float>(settings.sigma_surface_m * settings.sigma_surface_m);
    return feature;
}

/// All groups are planar points; those with the least curvature of each sector are matched.
void FeatureFinder::choose_planar(std::uint16_t ring, const FeatureSettings& settings,
                                  std::vector<Feature>& planar) {
    const auto sectors = static_cast<std::size_t>(settings.sectors);
    for (std::size_t sector = 0; sector < sectors; ++sector) {
        find_groups(sector * ring_.size() / sectors, (sector + 1) * ring_.size() / sectors, settings);
        const std::size_t first = planar.size();
        std::size_t kept = 0;
        for (const Group& group : groups_)
            if (const auto mean = mean_of(group, ring, settings)) {
                planar.push_back(*mean);
                groups_[kept++] = group;
            }
        groups_.resize(kept);
        candidates_.resize(kept);
        for (std::size_t k = 0; k < groups_.size(); ++k) candidates_[k] = k;
        const auto most = std::min(candidates_.size(), static_cast<std::size_t>(settings.planes_per_sector));
        std::partial_sort(candidates_.begin(), candidates_.begin() + static_cast<std::ptrdiff_t>(most),
                          candidates_.end(), [this](std::size_t a, std::size_t b) {
                              return groups_[a].curvature < groups_[b].curvature ||
                                     (groups_[a].curvature == groups_[b].curvature && a < b);
                          });
        for (std::size_t k = 0; k < most; ++k) planar[first + candidates_[k]].matched = 1;
    }
}

}  // namespace loopline::lidar_odometry
