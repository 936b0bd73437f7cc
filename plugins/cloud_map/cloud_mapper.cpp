#include "cloud_map/cloud_mapper.h"

#include <algorithm>
#include <cmath>

namespace loopline::cloud_map {
namespace {

constexpr double tile_m = 25;  // about

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

}  // namespace

CloudMapper::CloudMapper(const CloudMapSettings& settings, int threads)
    : settings_(settings),
      per_voxel_(1 / settings.voxel_m),
      tile_blocks_(tile_blocks_for(settings.voxel_m)),
      workers_(threads),
      store_(settings.voxel_m) {}

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
    before_m_ = motion_.middle_m();
    judge_next();
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
    if (is_new) store_.bring_back(index, tile);  // a vehicle that comes back finds its places taken
    last_tile_ = &tile;
    last_tile_index_ = index;
    return tile;
}

void CloudMapper::insert(const Eigen::Vector3d& p_map_m, std::uint32_t time_ticks, std::uint16_t intensity) {
    constexpr double limit_m = 2e5;  // of CloudPoint
    if (!(p_map_m.cwiseAbs().maxCoeff() < limit_m)) return;
    CubeIndex of_block;
    Block::Local at;
    VoxelOffset offset;
    unsigned place = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const auto a = static_cast<std::size_t>(axis);
        const double in_voxels = p_map_m[axis] * per_voxel_;
        const std::int32_t whole = floor_to_int(in_voxels);
        of_block[a] = whole >> 3;
        at[a] = whole & 7;
        place = place << 3 | static_cast<unsigned>(at[a]);
        offset[a] =
            static_cast<std::uint8_t>(std::min<double>(offset_parts - 1, (in_voxels - whole) * offset_parts));
    }
    if (of_block != here_.index) {
        here_.index = of_block;
        here_.known = 0;
    }
    Block* block = block_beside({0, 0, 0});
    if (block != nullptr && block->is_taken(place)) return;
    if (is_near_another(at, offset)) return;
    if (block == nullptr) block = here_.beside[Here::itself] = &tile_of(of_block).block(of_block);
    Candidate candidate;
    candidate.time_ticks = time_ticks;
    candidate.intensity = intensity;
    candidate.place = static_cast<std::uint16_t>(place);
    candidate.view = views_taken_ + 1;
    block->hold(candidate, offset);
    ++new_candidates_;
}

Block* CloudMapper::block_beside(const std::array<int, 3>& step) {
    const auto k = static_cast<unsigned>(Here::itself + 9 * step[0] + 3 * step[1] + step[2]);
    if ((here_.known >> k & 1) == 0) {
        const CubeIndex index{here_.index[0] + step[0], here_.index[1] + step[1], here_.index[2] + step[2]};
        here_.beside[k] = tile_of(index).find(index);
        here_.known |= 1u << k;
    }
    return here_.beside[k];
}

/// In the block itself first, which mostly tells; then in those beside it whose nearest face, edge or corner
/// is near enough.
bool CloudMapper::is_near_another(const Block::Local& at, const VoxelOffset& offset) {
    constexpr int near2 = offset_parts * offset_parts;
    std::array<int, 3> side{}, gap2{};  // in 256 parts of a voxel's edge, to the middle of the nearest part
    unsigned sides = 0;
    for (unsigned axis = 0; axis < 3; ++axis) {
        if (at[axis] > 0 && at[axis] < Block::edge - 1) continue;
        side[axis] = at[axis] == 0 ? -1 : 1;
        const int gap = at[axis] == 0 ? offset[axis] + 1 : offset_parts - offset[axis];
        gap2[axis] = gap * gap;
        sides |= 1u << axis;
    }
    for (unsigned beside = 0; beside < 8; ++beside) {
        if ((beside & ~sides) != 0) continue;
        std::array<int, 3> step{};
        Block::Local from_there = at;
        int nearest2 = 0;
        for (unsigned axis = 0; axis < 3; ++axis) {
            if ((beside >> axis & 1) == 0) continue;
            step[axis] = side[axis];
            from_there[axis] -= Block::edge * side[axis];
            nearest2 += gap2[axis];
        }
        if (nearest2 >= near2) continue;
        const Block* block = block_beside(step);
        if (block != nullptr && block->has_nearer(from_there, offset)) return true;
    }
    return false;
}

/// Never before the view before it has judged everything: each sweep has its share of that, and no more.
bool CloudMapper::is_view_due(StampNs stamp_ns) const {
    if (pass_.is_under_way) return false;
    const double since_s = seconds_between(viewed_ns_, stamp_ns);
    return since_s < 0 || since_s >= settings_.removal.view_spacing_s ||
           (motion_.middle_m() - viewed_from_m_).norm() >= settings_.removal.view_spacing_m;
}

void CloudMapper::take_view(const lidar::SpinningScan& scan) {
    viewed_from_m_ = motion_.middle_m();
    viewed_ns_ = scan.stamp_ns;
    ++views_taken_;
    if (settings_.removal.remove_moving) {
        views_.emplace_back(scan, motion_);
        if (views_.size() > static_cast<std::size_t>(settings_.removal.views) + 1) views_.pop_front();
        clear_ = ClearImage(views_.back());
    }
    begin_pass(count_held());
    forget_far_tiles();
}

/// Returns how many looks of one view at each candidate, and again at points, take.
std::uint64_t CloudMapper::count_held() {
    std::uint64_t blocks = 0, candidates = 0, again = 0;
    for (const auto& [index, tile] : tiles_) {
        blocks += tile.blocks().size();
        for (const Block& block : tile.blocks()) {
            candidates += block.candidates().size();
            again += certain_looks(block);
        }
    }
    counts_.most_blocks = std::max(counts_.most_blocks, blocks);
    counts_.most_candidates = std::max(counts_.most_candidates, candidates);
    return candidates + again;
}

void CloudMapper::finish() {
    while (pass_.is_under_way) judge_next();
    count_held();
    std::vector<Piece> all;
    for (auto& [index, tile] : tiles_) all.push_back({index, &tile, 0, tile.blocks().size()});
    judge_all(all, true);
    store_.leave_out_what_is_gone();
    tiles_.clear();
    views_.clear();
    forget_where_we_are();
}

}  // namespace loopline::cloud_map
