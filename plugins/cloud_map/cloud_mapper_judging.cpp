/// Which candidates of a cloud are points of it, and which were only passing by: as views tell, a share of
/// them with each sweep.
#include <algorithm>
#include <bitset>
#include <cmath>

#include "cloud_map/cloud_mapper.h"

namespace loopline::cloud_map {
namespace {

constexpr double fewest_sweeps = 2, most_sweeps = 5;  // that a view's judging is spread over
constexpr std::uint64_t pieces_per_sweep = 16;        // among the threads
constexpr unsigned certain_looked_at_by = 4;          // a view asks about one point of so many
constexpr double beyond_range_m =
    15;  // where a tile is forgotten: not at once, for a vehicle that goes to and fro

void count_up(std::uint8_t& count) {
    if (count < 255) ++count;
}

}  // namespace

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

CubeIndex CloudMapper::voxel_at(const Block& block, unsigned place) const {
    CubeIndex voxel;
    for (std::size_t axis = 0; axis < 3; ++axis)
        voxel[axis] = block.index[axis] * Block::edge + static_cast<int>(place >> (6 - 3 * axis) & 7);
    return voxel;
}

Eigen::Vector3d CloudMapper::place_m(const Block& block, unsigned place) const {
    const CubeIndex voxel = voxel_at(block, place);
    const VoxelOffset& offset = block.offset_of(place);
    Eigen::Vector3d p_m;
    for (std::size_t axis = 0; axis < 3; ++axis)
        p_m[static_cast<int>(axis)] = (voxel[axis] + (offset[axis] + 0.5) / offset_parts) * settings_.voxel_m;
    return p_m;
}

CloudPoint CloudMapper::point_of(const Block& block, const Candidate& candidate) const {
    const Eigen::Vector3d p_m = place_m(block, candidate.place);
    CloudPoint point;
    for (int axis = 0; axis < 3; ++axis)
        point.place[static_cast<std::size_t>(axis)] =
            static_cast<std::int32_t>(std::llround(p_m[axis] / CloudPoint::unit_m));
    point.time_ticks = candidate.time_ticks;
    point.intensity = candidate.intensity;
    return point;
}

/// By the latest view, at any of the points that it has given.
bool CloudMapper::may_be_looked_through(const Block& block) const {
    const RangeView& view = views_.back();
    const Block::Box box = block.box_of_given();
    Eigen::Vector3d middle_m;
    Eigen::Vector3f half_m;
    for (int axis = 0; axis < 3; ++axis) {
        const auto a = static_cast<std::size_t>(axis);
        middle_m[axis] =
            (block.index[a] * Block::edge + 0.5 * (box.first[a] + box.last[a] + 1)) * settings_.voxel_m;
        half_m[axis] = static_cast<float>(0.5 * (box.last[a] - box.first[a] + 1) * settings_.voxel_m);
    }
    return clear_.may_look_through(view, (middle_m - view.origin_m()).cast<float>(), half_m,
                                   settings_.removal.view);
}

/// What stood for long may have left since: a clamped count (Yguel, Aycard, Laugier 2007) forgets how often
/// it was seen before. A view asks about one point in `certain_looked_at_by`, and about those in doubt; where
/// it looked through one of them, about all others of the block.
void CloudMapper::look_again(Block& block, Verdict& verdict) const {
    const bool may_be_through = may_be_looked_through(block);
    if (!may_be_through && !block.is_doubted()) return;
    const RangeView& view = views_.back();
    bool is_through = false;
    std::bitset<Block::voxels> asked;
    const auto stays = [&](unsigned place, std::uint8_t& doubt) {
        asked.set(place);
        const Evidence evidence =
            view.look((place_m(block, place) - view.origin_m()).cast<float>(), settings_.removal.view);
        if (evidence == Evidence::seen && doubt > 0) --doubt;
        if (evidence != Evidence::through) return true;
        is_through = true;
        if (++doubt < settings_.removal.surely_there) return true;
        verdict.gone.push_back(pack(voxel_at(block, place)));
        return false;
    };
    block.look_again([&](unsigned place, std::uint8_t& doubt) {
        const bool is_due = may_be_through && (place + views_taken_) % certain_looked_at_by == 0;
        return doubt == 0 && !is_due ? true : stays(place, doubt);
    });
    if (!is_through) return;
    block.look_again(
        [&](unsigned place, std::uint8_t& doubt) { return asked.test(place) ? true : stays(place, doubt); });
}

void CloudMapper::judge(const Piece& piece, bool is_last, Verdict& verdict) const {
    const bool looks = settings_.removal.remove_moving && !is_last;
    for (std::size_t b = piece.begin; b < piece.end; ++b) {
        Block& block = piece.tile->blocks()[b];
        if (looks && block.points_given() > 0) look_again(block, verdict);
        if (block.candidates().empty()) continue;
        block.judge([&](Candidate& candidate) {
            if (!is_last && candidate.view > views_taken_) return Block::Fate::stays;  // the next view's
            if (looks) look_at(place_m(block, candidate.place), candidate);
            if (looks && !is_decided(candidate)) return Block::Fate::stays;
            if (settings_.removal.remove_moving && is_moving(candidate)) {
                ++verdict.moving;
                return Block::Fate::dropped;
            }
            verdict.given.push_back(point_of(block, candidate));
            return Block::Fate::given;
        });
    }
}

/// Each piece by itself, whoever does it; what is new is appended in the order of the pieces.
void CloudMapper::judge_all(const std::vector<Piece>& pieces, bool is_last) {
    std::vector<Verdict> verdicts(pieces.size());
    workers_.run(pieces.size(), [&](std::size_t k) { judge(pieces[k], is_last, verdicts[k]); });
    Verdict of_tile;
    for (std::size_t k = 0; k < pieces.size(); ++k) {
        const Verdict& v = verdicts[k];
        of_tile.given.insert(of_tile.given.end(), v.given.begin(), v.given.end());
        of_tile.gone.insert(of_tile.gone.end(), v.gone.begin(), v.gone.end());
        counts_.moving += v.moving + v.gone.size();
        if (k + 1 < pieces.size() && pieces[k + 1].index == pieces[k].index) continue;
        store_.append(pieces[k].index, of_tile.given, of_tile.gone);
        of_tile = {};
    }
}

/// All candidates are judged by the latest view before the next one is due, as fast as the vehicle is now:
/// with each sweep the same number of looks.
void CloudMapper::begin_pass(std::uint64_t looks_of_one) {
    const std::uint64_t asked_of_all = std::max<std::size_t>(1, views_.size());
    const std::uint64_t looks = looks_of_one - new_candidates_ + new_candidates_ * asked_of_all;
    const double way_m = std::max(1e-3, (motion_.middle_m() - before_m_).norm());
    const auto sweeps = static_cast<std::uint64_t>(
        std::clamp(std::ceil(settings_.removal.view_spacing_m / way_m), fewest_sweeps, most_sweeps));
    pass_ = {!tiles_.empty(), tiles_.empty() ? TileIndex{} : tiles_.begin()->first, 0, looks / sweeps + 1};
    new_candidates_ = 0;
}

/// About: blocks in which something was looked through are few.
std::uint64_t CloudMapper::certain_looks(const Block& block) const {
    return settings_.removal.remove_moving ? block.points_given() / certain_looked_at_by : 0;
}

std::uint64_t CloudMapper::looks_at(const Block& block) const {
    std::uint64_t looks = certain_looks(block);
    for (const Candidate& candidate : block.candidates())
        looks += candidate.view < views_taken_ ? 1 : candidate.view == views_taken_ ? views_.size() : 0;
    return looks;
}

/// The next candidates of the pass, in pieces of about as many looks.
void CloudMapper::judge_next() {
    if (!pass_.is_under_way) return;
    const std::uint64_t per_piece = pass_.looks_per_sweep / pieces_per_sweep + 1;
    std::vector<Piece> pieces;
    std::uint64_t looks = 0, of_piece = 0;
    auto tile = tiles_.lower_bound(pass_.tile);
    std::size_t block = tile != tiles_.end() && tile->first == pass_.tile ? pass_.block : 0;
    for (; tile != tiles_.end() && looks < pass_.looks_per_sweep; ++tile, block = 0) {
        const std::size_t blocks = tile->second.blocks().size();
        while (block < blocks && looks < pass_.looks_per_sweep) {
            Piece piece{tile->first, &tile->second, block, block};
            for (of_piece = 0; piece.end < blocks && of_piece < per_piece; ++piece.end)
                of_piece += looks_at(piece.tile->blocks()[piece.end]);
            looks += of_piece;
            block = piece.end;
            pieces.push_back(piece);
        }
        if (block < blocks) break;
    }
    pass_.is_under_way = tile != tiles_.end();
    if (pass_.is_under_way) pass_.tile = tile->first, pass_.block = block;
    judge_all(pieces, false);
}

void CloudMapper::forget_far_tiles() {
    const double edge_m = tile_blocks_ * Block::edge * settings_.voxel_m;
    const double keep_m = settings_.max_range_m + beyond_range_m + edge_m;
    std::vector<Piece> far;
    for (auto& [index, tile] : tiles_) {
        const Eigen::Vector2d middle_m = edge_m * (Eigen::Vector2d(index[0], index[1]).array() + 0.5);
        if ((middle_m - viewed_from_m_.head<2>()).norm() > keep_m)
            far.push_back({index, &tile, 0, tile.blocks().size()});
    }
    judge_all(far, true);
    for (const Piece& piece : far) {
        store_.put_away(piece.index, *piece.tile);
        tiles_.erase(piece.index);
    }
    forget_where_we_are();
}

}  // namespace loopline::cloud_map
