#include "lidar_mapping/surface_map.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "api/fetch.h"

namespace loopline::lidar_mapping {
namespace {

constexpr std::size_t first_slots = 1024;
/// Where one ring of a sweep crosses a cube it leaves a line that is no edge; it lies level, or nearly so.
constexpr float upright = 0.7F;
constexpr int parts = 4;  ///< of a cube, along each of its edges

VoxelIndex unpack(VoxelKey key) {
    const auto part = [key](int shift) {
        return static_cast<std::int32_t>(static_cast<std::int64_t>(key << (64 - 21 - shift)) >> (64 - 21));
    };
    return {part(42), part(21), part(0)};
}

Eigen::Map<const Eigen::Vector3f> vector(const std::array<float, 3>& a) {
    return Eigen::Map<const Eigen::Vector3f>(a.data());
}
void set(std::array<float, 3>& a, const Eigen::Vector3f& v) {
    Eigen::Map<Eigen::Vector3f>(a.data()) = v;
}

/// From the middle of its cube, in parts of the edge: -0.5 .. 0.5.
Eigen::Vector3f place_in(const Eigen::Vector3d& p_map_m, double per_edge, const VoxelIndex& index) {
    return {static_cast<float>(p_map_m.x() * per_edge - index.x - 0.5),
            static_cast<float>(p_map_m.y() * per_edge - index.y - 0.5),
            static_cast<float>(p_map_m.z() * per_edge - index.z - 0.5)};
}

std::uint64_t part_of(const Eigen::Vector3f& u) {
    const auto part = [](float v) { return std::clamp(static_cast<int>((v + 0.5F) * parts), 0, parts - 1); };
    return std::uint64_t{1} << ((part(u.x()) * parts + part(u.y())) * parts + part(u.z()));
}

/// The part that a return lies in, and those of the cube into which noise may have put it instead.
/// `variance`: along each axis, in parts of the edge, squared.
std::uint64_t parts_about(const Eigen::Vector3f& u, const Eigen::Vector3f& variance) {
    constexpr float sigmas = 2, largest = 0.4F / parts;
    std::uint64_t about = part_of(u);
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
        const float margin = std::min(largest, sigmas * std::sqrt(variance[axis]));
        Eigen::Vector3f beside = u;
        for (const float v : {u[axis] - margin, u[axis] + margin}) {
            beside[axis] = v;
            about |= part_of(beside);
        }
    }
    return about;
}

}  // namespace

SurfaceMap::SurfaceMap(const SurfaceMapSettings& settings) : settings_(settings) {
    double edge_m = settings.cell_m;
    for (int k = 0; k < settings.sizes; ++k, edge_m *= 2) {
        sizes_.emplace_back();
        sizes_.back().edge_m = edge_m;
        sizes_.back().per_edge = 1 / edge_m;
        sizes_.back().slots.resize(first_slots);
    }
}

VoxelIndex SurfaceMap::index_of(const Size& size, const Eigen::Vector3d& p_map_m) {
    const auto floor_of = [&](double v) {
        const double u = v * size.per_edge;
        const auto i = static_cast<std::int32_t>(u);
        return i > u ? i - 1 : i;
    };
    return {floor_of(p_map_m.x()), floor_of(p_map_m.y()), floor_of(p_map_m.z())};
}

/// The cubes around a few places. Neither slots nor cubes are in the processor's caches: all slots are on
/// their way before the first is looked at, and then all cubes.
template <class PlaceOf>
void SurfaceMap::ask(const Size& size, std::size_t count, PlaceOf place_of,
                     std::array<Asked, at_once>& asked) {
    const std::size_t mask = size.slots.size() - 1;
    for (std::size_t k = 0; k < count; ++k) {
        asked[k].index = index_of(size, place_of(k));
        asked[k].key = pack(asked[k].index);
        fetch(&size.slots[hash(asked[k].key) & mask]);
    }
    for (std::size_t k = 0; k < count; ++k) {
        asked[k].cell = find_cell(size, asked[k].key);
        fetch(asked[k].cell);
    }
}

const SurfaceMap::Cell* SurfaceMap::find_cell(const Size& size, VoxelKey key) {
    const std::size_t mask = size.slots.size() - 1;
    for (std::size_t k = hash(key) & mask;; k = (k + 1) & mask) {
        const Size::Slot& slot = size.slots[k];
        if (slot.key == key) return &size[slot.cell];
        if (slot.key == no_voxel) return nullptr;
    }
}

SurfaceMap::Cell& SurfaceMap::cell_at(Size& size, VoxelKey key) {
    if (10 * (std::size_t{size.cells} + 1) > 6 * size.slots.size()) make_slots(size, 2 * size.slots.size());
    const std::size_t mask = size.slots.size() - 1;
    for (std::size_t k = hash(key) & mask;; k = (k + 1) & mask) {
        Size::Slot& slot = size.slots[k];
        if (slot.key == key) return size[slot.cell];
        if (slot.key != no_voxel) continue;
        slot = {key, size.cells};
        return append(size, key);
    }
}

SurfaceMap::Cell& SurfaceMap::append(Size& size, VoxelKey key) {
    if (size.cells == size.pieces.size() * Size::piece_cells)
        size.pieces.push_back(std::make_unique<Cell[]>(Size::piece_cells));
    Cell& cell = size[size.cells++];
    cell = {};
    cell.key = key;
    return cell;
}

void SurfaceMap::make_slots(Size& size, std::size_t slots) {
    size.slots.assign(slots, {});
    const std::size_t mask = slots - 1;
    for (std::uint32_t i = 0; i < size.cells; ++i) {
        std::size_t k = hash(size[i].key) & mask;
        while (size.slots[k].key != no_voxel) k = (k + 1) & mask;
        size.slots[k] = {size[i].key, i};
    }
}

void SurfaceMap::add(std::size_t which, const PlacedReturn& seen) {
    Size& size = sizes_[which];
    const VoxelIndex index = index_of(size, seen.p_map_m);
    add(size, index, pack(index), seen);
}

void SurfaceMap::add(std::size_t which, const std::vector<PlacedReturn>& returns) {
    Size& size = sizes_[which];
    std::array<Asked, at_once> asked;
    for (std::size_t begin = 0; begin < returns.size(); begin += at_once) {
        const std::size_t count = std::min(at_once, returns.size() - begin);
        ask(
            size, count, [&](std::size_t k) { return returns[begin + k].p_map_m; }, asked);
        for (std::size_t k = 0; k < count; ++k) add(size, asked[k].index, asked[k].key, returns[begin + k]);
    }
}

void SurfaceMap::add(Size& size, const VoxelIndex& index, VoxelKey key, const PlacedReturn& seen) {
    Cell& cell = cell_at(size, key);
    const Eigen::Vector3f u = place_in(seen.p_map_m, size.per_edge, index);
    // What a lidar sees again and again from where it stands counts once: its rings would else fill the cube
    // before it moves on, and sees what lies between them. In a part that a surface only touches, the few
    // returns that noise has put there would count as much as all others in theirs, and draw the surface to
    // it.
    if ((cell.seen & part_of(u)) != 0) return;
    const Eigen::Matrix3f noise = static_cast<float>(size.per_edge * size.per_edge) * seen.noise_m2;
    if ((cell.seen & parts_about(u, noise.diagonal())) != 0) return;
    cell.seen |= part_of(u);
    ++cell.returns;
    // Noise spreads a single ring on the ground along its beams, or to where the vehicle seemed to be, into a
    // plane that is none: it is taken out of the squares.
    for (Eigen::Index a = 0, k = 0; a < 3; ++a) {
        cell.sum[static_cast<std::size_t>(a)] += u[a];
        for (Eigen::Index b = 0; b <= a; ++b)
            cell.squares[static_cast<std::size_t>(k++)] += u[a] * u[b] - noise(a, b);
    }
    cell.noise += noise.trace();
    cell.sweeps += static_cast<float>(sweeps_);
    if (cell.returns >= settings_.min_returns && 8 * cell.returns >= 9 * cell.fitted) fit(size, cell);
}

void SurfaceMap::fit(const Size& size, Cell& cell) const {
    cell.fitted = cell.returns;
    const float n = cell.returns;
    const Eigen::Vector3f mean = vector(cell.sum) / n;
    Eigen::Matrix3f covariance;
    covariance << cell.squares[0], cell.squares[1], cell.squares[3], cell.squares[1], cell.squares[2],
        cell.squares[4], cell.squares[3], cell.squares[4], cell.squares[5];
    covariance = covariance / n - mean * mean.transpose();
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f> eigen;
    eigen.computeDirect(covariance);
    const auto edge2 = static_cast<float>(size.edge_m * size.edge_m),
               thick2 = static_cast<float>(settings_.max_thickness_m * settings_.max_thickness_m),
               noise2 = static_cast<float>(settings_.sigma_range_m * settings_.sigma_range_m);
    cell.kind = SurfaceKind::none;
    if (edge2 * eigen.eigenvalues()[0] < -noise2) return;  // more was taken off than there is
    // What is hardly longer or wider than the noise has no direction.
    const float least_m2 = std::max(noise2, edge2 * cell.noise / n);
    const Eigen::Vector3f variance_m2 = edge2 * eigen.eigenvalues().cwiseMax(0.0F);
    // A few returns lie on a plane by chance: those of a lidar as it is known are put beside them.
    const auto with_noise = [&](float scatter_m2) {
        constexpr float known = 2;
        return (n * scatter_m2 + known * noise2) / (n + known);
    };
    const Eigen::Matrix3f& axes = eigen.eigenvectors();
    if (variance_m2[0] < thick2 && variance_m2[1] > 4 * std::max(variance_m2[0], least_m2)) {
        cell.kind = SurfaceKind::plane;
        set(cell.direction, axes.col(0));
        cell.variance_m2 = with_noise(variance_m2[0]);
    } else if (variance_m2[1] < thick2 && variance_m2[2] > 9 * std::max(variance_m2[1], least_m2) &&
               std::abs(axes(2, 2)) > upright) {
        cell.kind = SurfaceKind::edge;
        set(cell.direction, axes.col(2));
        cell.variance_m2 = with_noise(variance_m2[1]);
    } else {
        return;
    }
    set(cell.along, axes.col(2));
    cell.per_along_m2 = 1 / variance_m2[2];
    cell.per_beside_m2 = 1 / std::max(variance_m2[1], noise2);
}

bool SurfaceMap::has_return_near(const Eigen::Vector3d& p_map_m) const {
    const Size& size = sizes_.front();
    std::array<int, 3> part{};
    for (std::size_t axis = 0; axis < 3; ++axis)
        part[axis] =
            static_cast<int>(std::floor(p_map_m[static_cast<Eigen::Index>(axis)] * size.per_edge * parts));
    static_assert(parts == 4);
    // Cube by cube, of the neighbouring parts those that are in it.
    const auto cube = [](int of_part) { return of_part >> 2; };
    for (int x = cube(part[0] - 1); x <= cube(part[0] + 1); ++x)
        for (int y = cube(part[1] - 1); y <= cube(part[1] + 1); ++y)
            for (int z = cube(part[2] - 1); z <= cube(part[2] + 1); ++z) {
                const Cell* cell = find_cell(size, pack({x, y, z}));
                if (cell == nullptr) continue;
                const auto near = [](int of_part, int index) {
                    return std::pair(std::max(of_part - 1 - 4 * index, 0),
                                     std::min(of_part + 1 - 4 * index, 3));
                };
                const auto [x0, x1] = near(part[0], x);
                const auto [y0, y1] = near(part[1], y);
                const auto [z0, z1] = near(part[2], z);
                for (int i = x0; i <= x1; ++i)
                    for (int j = y0; j <= y1; ++j)
                        for (int k = z0; k <= z1; ++k)
                            if ((cell->seen >> ((i * parts + j) * parts + k) & 1) != 0) return true;
            }
    return false;
}

void SurfaceMap::look(const Size& size, const VoxelIndex& index, const Cell& cell, const MapReturn& seen,
                      SurfaceMatch& best) const {
    if (cell.kind == SurfaceKind::none) return;
    const float n = cell.returns;
    const Eigen::Vector3f offset_m = static_cast<float>(size.edge_m) *
                                     (place_in(seen.p_map_m, size.per_edge, index) - vector(cell.sum) / n);
    const Eigen::Vector3f direction = vector(cell.direction), along = vector(cell.along);
    const float a_m = along.dot(offset_m);
    const Eigen::Vector3f beside = direction.cross(along);
    float leverage = 1 + a_m * a_m * cell.per_along_m2;
    if (cell.kind == SurfaceKind::plane) {
        const float b_m = beside.dot(offset_m);
        leverage += b_m * b_m * cell.per_beside_m2;
    }
    const float across = direction.dot(seen.beam_map),
                by_range = cell.kind == SurfaceKind::plane ? across * across : 1 - across * across;
    const float return_m2 =
        cell.variance_m2 + static_cast<float>(settings_.sigma_range_m * settings_.sigma_range_m) * by_range;
    const float per_return_m2 = return_m2 / n, of_surface_m2 = per_return_m2 * leverage;
    if (cell.kind == SurfaceKind::plane &&
        per_return_m2 * cell.per_beside_m2 >
            static_cast<float>(settings_.max_sigma_normal_rad * settings_.max_sigma_normal_rad))
        return;
    if (of_surface_m2 > static_cast<float>(settings_.max_sigma_m * settings_.max_sigma_m)) return;
    const float variance_m2 = return_m2 + of_surface_m2;
    if (best.kind != SurfaceKind::none && variance_m2 >= best.variance_m2) return;
    best = {cell.kind,
            direction,
            offset_m,
            variance_m2,
            along,
            beside,
            per_return_m2 * cell.per_along_m2,
            per_return_m2 * cell.per_beside_m2,
            cell.sweeps / n};
}

SurfaceMatch SurfaceMap::find(const MapReturn& seen, std::size_t smallest) const {
    SurfaceMatch best;
    find(&seen, 1, smallest, &best);
    return best;
}

void SurfaceMap::find(const MapReturn* seen, std::size_t count, std::size_t smallest,
                      SurfaceMatch* best) const {
    for (std::size_t k = 0; k < count; ++k) best[k].kind = SurfaceKind::none;
    std::array<Asked, at_once> asked;
    for (std::size_t which = smallest; which < sizes_.size(); ++which) {
        const Size& size = sizes_[which];
        ask(
            size, count, [&](std::size_t k) { return seen[k].p_map_m; }, asked);
        for (std::size_t k = 0; k < count; ++k)
            if (asked[k].cell != nullptr) look(size, asked[k].index, *asked[k].cell, seen[k], best[k]);
    }
}

void SurfaceMap::for_each_plane(const std::function<void(const Eigen::Vector3f&, float)>& see) const {
    const Size& size = sizes_[std::min<std::size_t>(1, sizes_.size() - 1)];
    const auto noise2 = static_cast<float>(settings_.sigma_range_m * settings_.sigma_range_m),
               most = static_cast<float>(settings_.max_sigma_normal_rad * settings_.max_sigma_normal_rad);
    for (std::uint32_t i = 0; i < size.cells; ++i) {
        const Cell& cell = size[i];
        if (cell.kind != SurfaceKind::plane) continue;
        const float return_m2 = cell.variance_m2 + noise2,
                    variance = return_m2 / cell.returns * cell.per_beside_m2;
        if (variance > most) continue;
        // Of a plane that comes close to a face of the cube, noise has put a part into the next one: what is
        // left lies along the face.
        const Eigen::Vector3f normal = vector(cell.direction), mean = vector(cell.sum) / cell.returns;
        Eigen::Index across = 0;
        const float most_across = normal.cwiseAbs().maxCoeff(&across),
                    slant = (normal.lpNorm<1>() - most_across) / most_across / 2,
                    noise = 3 * std::sqrt(return_m2) * static_cast<float>(size.per_edge);
        if (std::abs(mean[across]) + slant + noise < 0.5F) see(normal, variance);
    }
}

void SurfaceMap::keep_around(const Eigen::Vector3d& p_map_m) {
    for (Size& size : sizes_) {
        const VoxelIndex around = index_of(size, p_map_m);
        const int radius = static_cast<int>(settings_.keep_radius_m * size.per_edge) + 1;
        std::uint32_t kept = 0;
        for (std::uint32_t i = 0; i < size.cells; ++i) {
            const VoxelIndex at = unpack(size[i].key);
            if (std::abs(at.x - around.x) > radius || std::abs(at.y - around.y) > radius ||
                std::abs(at.z - around.z) > radius)
                continue;
            if (kept != i) size[kept] = size[i];
            ++kept;
        }
        size.cells = kept;
        size.pieces.resize((kept + Size::piece_cells - 1) / Size::piece_cells);
        make_slots(size, size.slots.size());
    }
}

void SurfaceMap::clear() {
    for (Size& size : sizes_) {
        size.slots.assign(first_slots, {});
        size.pieces.clear();
        size.cells = 0;
    }
    sweeps_ = 0;
}

std::size_t SurfaceMap::cells() const {
    std::size_t cells = 0;
    for (const Size& size : sizes_) cells += size.cells;
    return cells;
}

}  // namespace loopline::lidar_mapping
