#include "cloud_map/cloud_mapper.h"

#include <algorithm>
#include <cmath>

namespace loopline::cloud_map {
namespace {

// Of the tiles, that is judged with each sweep: a view is no burden on one of them.
constexpr double share_per_sweep = 1.0 / 3;
constexpr double tile_m = 25;  // about
constexpr double beyond_range_m =
    15;  // where a tile is forgotten: not at once, for a vehicle that goes to and fro

std::int32_t floor_divide(std::int32_t a, std::int32_t b) {
    return a / b - (a % b != 0 && (a ^ b) < 0 ? 1 : 0);
}

int tile_blocks_for(double voxel_m) {
    return std::max(1, static_cast<int>(std::lround(tile_m / (voxel_m * Block::edge))));
}

/// std::floor() is a call into the library here.
std::int32_t floor_to_int(double x) {
    const auto whole = static_cast<std::int32_t>(x);
    return whole > x ? whole - 1 : whole;
}

void count_up(std::uint8_t& count) {
    if (count < 255) ++count;
}

}  // namespace

CloudMapper::CloudMapper(const CloudMapSettings& settings, int threads)
    : settings_(settings),
      per_voxel_(1 / settings.voxel_m),
      tile_blocks_(tile_blocks_for(settings.voxel_m)),
      workers_(threads) {}

bool CloudMapper::add(const lidar::SpinningScan& scan, const std::vector<std::uint16_t>& intensity,
                      const PoseAt& T_map_base) {
    if (!motion_.follow(scan, T_map_base)) return false;
    if (!has_sweeps_) {
        // Times are positive, also those of a first sweep that begins before its stamp.
        store_.cloud().first_ns = scan.stamp_ns + std::llround(1e9 * std::min(0.0, scan.begin_s));
        store_.cloud().has_intensity = !intensity.empty();
    }
    insert_points(scan, intensity);
    if (!has_sweeps_ || is_view_due(scan.stamp_ns)) take_view(scan);
    has_sweeps_ = true;
    judge_some(share_per_sweep);
    return true;
}

void CloudMapper::insert_points(const lidar::SpinningScan& scan,
                                const std::vector<std::uint16_t>& intensity) {
    const auto least2 = static_cast<float>(settings_.min_range_m * settings_.min_range_m),
               most2 = static_cast<float>(settings_.max_range_m * settings_.max_range_m);
    const double stamp_s = seconds_between(store_.cloud().first_ns, scan.stamp_ns);
    for (std::size_t i = 0; i < scan.points.size(); ++i) {
        const lidar::SpinningPoint& p = scan.points[i];
        const float range2 = p.x_m * p.x_m + p.y_m * p.y_m + p.z_m * p.z_m;
        if (!(range2 > least2 && range2 < most2)) continue;
        ++counts_.returns;
        const double ticks = (stamp_s + static_cast<double>(p.time_s)) / CloudPoint::tick_s;
        insert(motion_.p_map_m(p), static_cast<std::uint32_t>(std::clamp(ticks, 0.0, 4294967295.0)),
               i < intensity.size() ? intensity[i] : std::uint16_t{0});
    }
}

Tile& CloudMapper::tile_of(const CubeIndex& block) {
    const TileIndex index{floor_divide(block[0], tile_blocks_), floor_divide(block[1], tile_blocks_)};
    if (last_tile_ != nullptr && index == last_tile_index_) return *last_tile_;
    const auto [found, is_new] = tiles_.try_emplace(index);
    Tile& tile = found->second;
    // A vehicle that comes back finds its places taken.
    if (is_new)
        store_.for_each_of(index, [&](const CloudPoint& point) {
            CubeIndex voxel, of_block;
            unsigned place = 0;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                voxel[axis] = static_cast<std::int32_t>(
                    std::floor(point.place[axis] * (CloudPoint::unit_m / settings_.voxel_m)));
                of_block[axis] = voxel[axis] >> 3;
                place = place << 3 | static_cast<unsigned>(voxel[axis] & 7);
            }
            tile.block(of_block).give(place);
        });
    last_tile_ = &tile;
    last_tile_index_ = index;
    return tile;
}

void CloudMapper::insert(const Eigen::Vector3d& p_map_m, std::uint32_t time_ticks, std::uint16_t intensity) {
    constexpr double limit_m = 2e5;  // of CloudPoint
    if (!(p_map_m.cwiseAbs().maxCoeff() < limit_m)) return;
    CubeIndex of_block;
    unsigned place = 0;
    Candidate candidate;
    for (int axis = 0; axis < 3; ++axis) {
        const double at = p_map_m[axis] * per_voxel_;
        const std::int32_t whole = floor_to_int(at);
        of_block[static_cast<std::size_t>(axis)] = whole >> 3;
        place = place << 3 | static_cast<unsigned>(whole & 7);
        candidate.offset[static_cast<std::size_t>(axis)] =
            static_cast<std::uint8_t>(std::min(255.0, (at - whole) * 256));
    }
    const std::uint64_t key = pack(of_block);
    if (last_block_ == nullptr || key != last_block_key_) {
        last_block_ = &tile_of(of_block).block(of_block);
        last_block_key_ = key;
    }
    if (last_block_->is_taken(place)) return;
    candidate.time_ticks = time_ticks;
    candidate.intensity = intensity;
    candidate.place = static_cast<std::uint16_t>(place);
    candidate.view = views_taken_ + 1;
    last_block_->hold(candidate);
}

bool CloudMapper::is_view_due(StampNs stamp_ns) const {
    const double since_s = seconds_between(viewed_ns_, stamp_ns);
    return since_s < 0 || since_s >= settings_.removal.view_spacing_s ||
           (motion_.middle_m() - viewed_from_m_).norm() >= settings_.removal.view_spacing_m;
}

void CloudMapper::take_view(const lidar::SpinningScan& scan) {
    judge_some(1);
    viewed_from_m_ = motion_.middle_m();
    viewed_ns_ = scan.stamp_ns;
    ++views_taken_;
    if (settings_.removal.remove_moving) {
        views_.emplace_back(scan, motion_);
        if (views_.size() > static_cast<std::size_t>(settings_.removal.views) + 1) views_.pop_front();
    }
    count_held();
    judges_ = true;
    next_judged_ = tiles_.empty() ? TileIndex{} : tiles_.begin()->first;
    forget_far_tiles();
}

/// By the latest view, as many tiles as that share of all is, of those that it has not judged yet.
void CloudMapper::judge_some(double share) {
    if (!judges_) return;
    const auto most = static_cast<std::size_t>(std::ceil(share * static_cast<double>(tiles_.size())));
    std::vector<TileIndex> next;
    auto tile = tiles_.lower_bound(next_judged_);
    for (; tile != tiles_.end() && next.size() < most; ++tile) next.push_back(tile->first);
    judges_ = tile != tiles_.end();
    if (judges_) next_judged_ = tile->first;
    judge_all(next, false);
}

void CloudMapper::look_at(const Eigen::Vector3d& p_map_m, Candidate& candidate) const {
    // What is new since the view before is looked for in all of them, from the oldest on, so that what stands
    // there now but did not then is found out; what is older was, in those.
    const bool is_new = candidate.view == views_taken_;
    for (std::size_t k = is_new ? 0 : views_.size() - 1; k < views_.size() && !stands_still(candidate); ++k) {
        const RangeView& view = views_[k];
        const Evidence evidence =
            view.look((p_map_m - view.origin_m()).cast<float>(), settings_.removal.view);
        if (evidence == Evidence::seen) count_up(candidate.seen);
        if (evidence == Evidence::through) count_up(candidate.through);
    }
}

bool CloudMapper::is_moving(const Candidate& candidate) const {
    return candidate.through >= settings_.removal.least_through &&
           candidate.through > settings_.removal.through_per_seen * candidate.seen;
}

bool CloudMapper::stands_still(const Candidate& candidate) const {
    return candidate.through == 0 && candidate.seen >= settings_.removal.surely_there;
}

bool CloudMapper::is_decided(const Candidate& candidate) const {
    return stands_still(candidate) ||
           views_taken_ - candidate.view >= static_cast<std::uint32_t>(settings_.removal.views);
}

Eigen::Vector3d CloudMapper::place_m(const Block& block, const Candidate& candidate) const {
    Eigen::Vector3d p_m;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const int voxel = block.index[axis] * Block::edge + (candidate.place >> (6 - 3 * axis) & 7);
        p_m[static_cast<int>(axis)] = (voxel + (candidate.offset[axis] + 0.5) / 256) * settings_.voxel_m;
    }
    return p_m;
}

CloudPoint CloudMapper::point_of(const Block& block, const Candidate& candidate) const {
    const Eigen::Vector3d p_m = place_m(block, candidate);
    CloudPoint point;
    for (int axis = 0; axis < 3; ++axis)
        point.place[static_cast<std::size_t>(axis)] =
            static_cast<std::int32_t>(std::llround(p_m[axis] / CloudPoint::unit_m));
    point.time_ticks = candidate.time_ticks;
    point.intensity = candidate.intensity;
    return point;
}

void CloudMapper::judge(Tile& tile, bool is_last, std::vector<CloudPoint>& given,
                        std::uint64_t& moving) const {
    for (Block& block : tile.blocks()) {
        if (block.candidates().empty()) continue;
        block.judge([&](Candidate& candidate) {
            if (!is_last && candidate.view > views_taken_) return Block::Fate::stays;  // the next view's
            if (settings_.removal.remove_moving) {
                if (!is_last) look_at(place_m(block, candidate), candidate);
                if (!is_last && !is_decided(candidate)) return Block::Fate::stays;
                if (is_moving(candidate)) {
                    ++moving;
                    return Block::Fate::dropped;
                }
            }
            given.push_back(point_of(block, candidate));
            return Block::Fate::given;
        });
    }
}

/// Each tile by itself, whoever does it; their points are appended in the order of the tiles.
void CloudMapper::judge_all(const std::vector<TileIndex>& tiles, bool is_last) {
    std::vector<std::vector<CloudPoint>> given(tiles.size());
    std::vector<std::uint64_t> moving(tiles.size(), 0);
    std::vector<Tile*> at_work;
    for (const TileIndex& index : tiles) at_work.push_back(&tiles_.at(index));
    workers_.run(tiles.size(), [&](std::size_t k) { judge(*at_work[k], is_last, given[k], moving[k]); });
    for (std::size_t k = 0; k < tiles.size(); ++k) {
        store_.append(tiles[k], given[k]);
        counts_.moving += moving[k];
    }
}

void CloudMapper::forget_far_tiles() {
    const double edge_m = tile_blocks_ * Block::edge * settings_.voxel_m;
    const double keep_m = settings_.max_range_m + beyond_range_m + edge_m;
    std::vector<TileIndex> far;
    for (const auto& [index, tile] : tiles_) {
        const Eigen::Vector2d middle_m = edge_m * (Eigen::Vector2d(index[0], index[1]).array() + 0.5);
        if ((middle_m - viewed_from_m_.head<2>()).norm() > keep_m) far.push_back(index);
    }
    judge_all(far, true);
    for (const TileIndex& index : far) tiles_.erase(index);
    last_tile_ = nullptr;
    last_block_ = nullptr;
}

void CloudMapper::count_held() {
    std::uint64_t blocks = 0, candidates = 0;
    for (const auto& [index, tile] : tiles_) {
        blocks += tile.blocks().size();
        for (const Block& block : tile.blocks()) candidates += block.candidates().size();
    }
    counts_.most_blocks = std::max(counts_.most_blocks, blocks);
    counts_.most_candidates = std::max(counts_.most_candidates, candidates);
}

void CloudMapper::finish() {
    judge_some(1);
    count_held();
    std::vector<TileIndex> all;
    for (const auto& [index, tile] : tiles_) all.push_back(index);
    judge_all(all, true);
    tiles_.clear();
    views_.clear();
    last_tile_ = nullptr;
    last_block_ = nullptr;
}

}  // namespace loopline::cloud_map
