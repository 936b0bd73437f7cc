/// The map of a spinning lidar: points that keep their distance, without what moved, on disk but for the
/// surroundings of the vehicle.
#pragma once

#include <deque>
#include <map>

#include "api/worker_pool.h"
#include "cloud_map/clear_image.h"
#include "cloud_map/sweep_motion.h"
#include "cloud_map/tile_store.h"

namespace loopline::cloud_map {

struct RemovalSettings {
    bool remove_moving = true;
    ViewSettings view;
    double view_spacing_m = 2;    ///< a sweep becomes a view after so much way,
    double view_spacing_s = 1;    ///< or so much time
    int views = 24;               ///< that judge a place before, and as many after it was first seen
    int least_through = 2;        ///< views that must have looked through a place
    double through_per_seen = 1;  ///< and so many for each view that saw something there
    /// Views that saw something there, while none looked through, are enough: it stands still. Until so many
    /// more look through than still see it.
    int surely_there = 4;
};

struct CloudMapSettings {
    double voxel_m = 0.1;  ///< no two points are nearer to each other, nor in the same cube with this edge
    double min_range_m = 1.5, max_range_m = 60;
    RemovalSettings removal;
};

/// What memory holds, and what came of the rest.
struct CloudMapCounts {
    std::uint64_t returns = 0;                           ///< within the range gate
    std::uint64_t moving = 0;                            ///< points left out since others looked through them
    std::uint64_t most_blocks = 0, most_candidates = 0;  ///< held at any time
};

class CloudMapper {
 public:
    CloudMapper(const CloudMapSettings& settings, int threads);

    /// The map lies in files of `folder` from now on whose names begin with `name`; before the first sweep.
    void keep_in(const std::filesystem::path& folder, const std::string& name) {
        store_.keep_in(folder, name);
    }
    /// Adds a sweep; false where `T_map_base` has no pose for a moment of it. `intensity`: of each point of
    /// the scan, or empty.
    bool add(const lidar::SpinningScan& scan, const std::vector<std::uint16_t>& intensity,
             const PoseAt& T_map_base);
    /// Decides on all that is left. The map is complete then.
    void finish();

    const StoredCloud& cloud() const { return store_.cloud(); }
    const CloudMapCounts& counts() const { return counts_; }

 private:
    template <class Archive>
    friend void fields(Archive&, CloudMapper&);
    using TileIndex = TileStore::TileIndex;

    /// Neighbouring blocks of a tile.
    struct Piece {
        TileIndex index{};
        Tile* tile = nullptr;
        std::size_t begin = 0, end = 0;
    };
    /// How far the latest view has judged the candidates.
    struct Pass {
        bool is_under_way = false;
        TileIndex tile{};  ///< that is next, from this block on
        std::uint64_t block = 0;
        std::uint64_t looks_per_sweep = 0;
    };

    Tile& tile_of(const CubeIndex& block);
    void insert(const Eigen::Vector3d& p_map_m, std::uint32_t time_ticks, std::uint16_t intensity);
    Block* block_beside(const std::array<int, 3>& step);
    bool is_near_another(const Block::Local& at, const VoxelOffset& offset);
    void forget_where_we_are() {
        last_tile_ = nullptr;
        here_.known = 0;
    }
    void insert_points(const lidar::SpinningScan& scan, const std::vector<std::uint16_t>& intensity);
    bool is_view_due(StampNs stamp_ns) const;
    void take_view(const lidar::SpinningScan& scan);
    /// What a view says of a piece of a tile.
    struct Verdict {
        std::vector<CloudPoint> given;
        std::vector<std::uint64_t> gone;  ///< voxels, packed
        std::uint64_t moving = 0;         ///< candidates left out
    };
    void judge(const Piece& piece, bool is_last, Verdict& verdict) const;
    void look_again(Block& block, Verdict& verdict) const;
    bool may_be_looked_through(const Block& block) const;
    void look_at(const Eigen::Vector3d& p_map_m, Candidate& candidate) const;
    bool is_moving(const Candidate& candidate) const;
    bool stands_still(const Candidate& candidate) const;
    bool is_decided(const Candidate& candidate) const;
    CloudPoint point_of(const Block& block, const Candidate& candidate) const;
    CubeIndex voxel_at(const Block& block, unsigned place) const;
    Eigen::Vector3d place_m(const Block& block, unsigned place) const;
    void judge_all(const std::vector<Piece>& pieces, bool is_last);
    void begin_pass(std::uint64_t looks_of_one);
    std::uint64_t looks_at(const Block& block) const;
    void judge_next();
    void forget_far_tiles();
    std::uint64_t certain_looks(const Block& block) const;
    std::uint64_t count_held();

    CloudMapSettings settings_;
    double per_voxel_;  ///< of a metre
    int tile_blocks_;   ///< blocks along an edge of a tile
    WorkerPool workers_;
    SweepMotion motion_;

    TileStore store_;
    std::map<TileIndex, Tile> tiles_;  ///< around the vehicle
    std::deque<RangeView> views_;      ///< the latest, of which the last has number `views_taken_`
    ClearImage clear_;                 ///< of the last one
    std::uint32_t views_taken_ = 0;
    Eigen::Vector3d viewed_from_m_ = Eigen::Vector3d::Zero();
    StampNs viewed_ns_ = 0;
    bool has_sweeps_ = false;
    Eigen::Vector3d before_m_ = Eigen::Vector3d::Zero();  ///< the lidar, in the sweep before
    std::uint64_t new_candidates_ = 0;                    ///< since the latest view
    Pass pass_;
    CloudMapCounts counts_;

    /// A block and those about it, as far as anyone asked for them.
    struct Here {
        CubeIndex index{};
        std::uint32_t known = 0;  ///< a bit each; a block that is known to be none is null
        std::array<Block*, 27> beside{};
        static constexpr int itself = 13;
    };
    // The tile and block met last: neighbouring beams mostly meet the same.
    Tile* last_tile_ = nullptr;
    TileIndex last_tile_index_{};
    Here here_;
};

}  // namespace loopline::cloud_map
