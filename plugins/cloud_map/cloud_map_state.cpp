/// What a break between two sweeps must keep. The map itself is on disk already.
#include "api/state_archive.h"
#include "cloud_map/cloud_map_module.h"

namespace loopline {
namespace cloud_map {

/// Many elements without pointers at once, which is ten times as fast as one by one.
template <class Archive, class T>
void plain(Archive& archive, std::vector<T>& elements) {
    static_assert(std::is_trivially_copyable_v<T>);
    std::uint64_t count = elements.size();
    archive(count);
    if constexpr (Archive::reading) {
        elements.resize(count);
        if (count > 0) archive.archive().ReadBuffer(elements.data(), count * sizeof(T));
    } else {
        if (count > 0) archive.archive().WriteBuffer(elements.data(), count * sizeof(T));
    }
}

template <class Archive>
void fields(Archive& archive, StampedPose3& pose) {
    archive(pose.stamp_ns, pose.T_map_base);
}

template <class Archive>
void fields(Archive& archive, PoseWindow& window) {
    archive(window.poses_);
}

template <class Archive>
void fields(Archive& archive, RangeView& view) {
    const auto sector = [](auto& a, RangeView::Sector& s) { a(s.R_lidar_map, s.from_origin_m); };
    archive(view.origin_m_, view.slopes_, view.ring_at_, view.first_slope_, view.bins_per_slope_,
            view.columns_);
    archive.each(view.sectors_, sector);
    plain(archive, view.ranges_);
}

template <class Archive>
void fields(Archive& archive, Block& block) {
    for (auto& x : block.index) archive(x);
    for (auto& x : block.given_) archive(x);
    for (auto& x : block.held_) archive(x);
    for (auto& x : block.before_word_) archive(x);
    archive(block.points_given_);
    plain(archive, block.offsets_);
    plain(archive, block.doubts_);
    plain(archive, block.candidates_);
}

template <class Archive>
void fields(Archive& archive, Tile& tile) {
    archive(tile.blocks_);
    if constexpr (Archive::reading) tile.make_slots();
}

/// A map from places of tiles, which the archive does not know by itself.
template <class Archive, class T>
void fields_by_tile(Archive& archive, std::map<TileStore::TileIndex, T>& map) {
    std::uint64_t count = map.size();
    archive(count);
    auto next = map.begin();
    for (std::uint64_t k = 0; k < count; ++k) {
        TileStore::TileIndex index{};
        if constexpr (!Archive::reading) index = next->first;
        archive(index[0], index[1]);
        if constexpr (Archive::reading) next = map.try_emplace(index).first;
        archive(next->second);
        ++next;
    }
}

template <class Archive>
void fields(Archive& archive, TileStore::Place& place) {
    archive(place.first, place.count, place.first_offset);
}

template <class Archive>
void fields(Archive& archive, TileStore& store) {
    archive(store.cloud_, store.gone_, store.stretches_, store.taken_, store.offsets_);
    fields_by_tile(archive, store.last_stretch_);
    fields_by_tile(archive, store.place_of_taken_);
}

template <class Archive>
void fields(Archive& archive, CloudMapper& m) {
    archive(m.store_, m.views_, m.views_taken_, m.viewed_from_m_, m.viewed_ns_, m.has_sweeps_, m.before_m_,
            m.new_candidates_);
    if constexpr (Archive::reading)
        if (!m.views_.empty()) m.clear_ = ClearImage(m.views_.back());
    archive(m.pass_.is_under_way, m.pass_.tile[0], m.pass_.tile[1], m.pass_.block, m.pass_.looks_per_sweep);
    fields_by_tile(archive, m.tiles_);
    archive(m.counts_.returns, m.counts_.moving, m.counts_.most_blocks, m.counts_.most_candidates);
}

}  // namespace cloud_map

template <class Archive>
void fields(Archive& archive, CloudMapModule& m) {
    archive(m.path_);
    archive.each(m.waiting_, [](auto& a, auto& sweep) {
        lidar::SpinningScan& scan = sweep.scan;
        a(scan.label, scan.stamp_ns, scan.T_base_lidar, scan.begin_s, scan.end_s);
        cloud_map::plain(a, scan.points);
        cloud_map::plain(a, scan.ring_begin);
        cloud_map::plain(a, sweep.intensity);
    });
    archive(m.counts_.mapped, m.counts_.without_pose);
    if (m.mapper_) archive(*m.mapper_);
}

void CloudMapModule::save_state(mrpt::serialization::CArchive& out) const {
    write_state(out, info().name, 5, *this);
}

void CloudMapModule::load_state(mrpt::serialization::CArchive& in) {
    read_state(in, info().name, 5, *this);
}

}  // namespace loopline
