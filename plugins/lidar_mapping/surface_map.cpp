#include "lidar_mapping/surface_map.h"

#include <Eigen/Eigenvalues>
#include <algorithm>

namespace loopline::lidar_mapping {
namespace {

constexpr std::size_t first_slots = 1024;
/// Where one ring of a sweep crosses a cube it leaves a line that is no edge; it lies level, or nearly so.
constexpr float upright = 0.7F;

VoxelIndex unpack(VoxelKey key) {
    const auto part = [key](int shift) {
        return static_cast<std::int32_t>(static_cast<std::int64_t>(key << (64 - 21 - shift)) >> (64 - 21));
    };
    return {part(42), part(21), part(0)};
}

}  // namespace

SurfaceMap::SurfaceMap(const SurfaceMapSettings& settings) : settings_(settings) {
    double edge_m = settings.cell_m;
    for (int k = 0; k < settings.sizes; ++k, edge_m *= 2) {
        sizes_.emplace_back();
        sizes_.back().edge_m = edge_m;
        sizes_.back().per_edge = 1 / edge_m;
        sizes_.back().table.resize(first_slots);
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

const SurfaceMap::Cell* SurfaceMap::find_cell(const Size& size, VoxelKey key) {
    const std::size_t mask = size.table.size() - 1;
    for (std::size_t k = hash(key) & mask;; k = (k + 1) & mask) {
        const Cell& cell = size.table[k];
        if (cell.key == key) return &cell;
        if (cell.key == no_voxel) return nullptr;
    }
}

SurfaceMap::Cell& SurfaceMap::cell_at(Size& size, VoxelKey key) {
    if (10 * (size.used + 1) > 6 * size.table.size()) rebuild(size, 2 * size.table.size(), nullptr, 0);
    const std::size_t mask = size.table.size() - 1;
    for (std::size_t k = hash(key) & mask;; k = (k + 1) & mask) {
        Cell& cell = size.table[k];
        if (cell.key == key) return cell;
        if (cell.key != no_voxel) continue;
        cell.key = key;
        ++size.used;
        ++used_;
        return cell;
    }
}

void SurfaceMap::add(const Eigen::Vector3d& p_map_m) {
    for (Size& size : sizes_) {
        const VoxelIndex index = index_of(size, p_map_m);
        Cell& cell = cell_at(size, pack(index));
        if (cell.returns >= settings_.enough_returns) continue;
        const std::array<float, 3> u = {static_cast<float>(p_map_m.x() * size.per_edge - index.x - 0.5),
                                        static_cast<float>(p_map_m.y() * size.per_edge - index.y - 0.5),
                                        static_cast<float>(p_map_m.z() * size.per_edge - index.z - 0.5)};
        ++cell.returns;
        for (std::size_t a = 0, k = 0; a < 3; ++a) {
            cell.sum[a] += u[a];
            for (std::size_t b = 0; b <= a; ++b) cell.squares[k++] += u[a] * u[b];
        }
        if (cell.returns >= settings_.min_returns && 4 * cell.returns >= 5 * cell.fitted) fit(size, cell);
    }
}

void SurfaceMap::fit(const Size& size, Cell& cell) const {
    cell.fitted = cell.returns;
    const auto n = static_cast<float>(cell.returns);
    const Eigen::Vector3f mean = Eigen::Map<const Eigen::Vector3f>(cell.sum.data()) / n;
    Eigen::Matrix3f covariance;
    covariance << cell.squares[0], cell.squares[1], cell.squares[3], cell.squares[1], cell.squares[2],
        cell.squares[4], cell.squares[3], cell.squares[4], cell.squares[5];
    covariance = covariance / n - mean * mean.transpose();
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f> eigen;
    eigen.computeDirect(covariance);
    const auto edge2 = static_cast<float>(size.edge_m * size.edge_m),
               thin2 = static_cast<float>(settings_.max_thickness_m * settings_.max_thickness_m) / edge2,
               wide2 = static_cast<float>(settings_.min_width_m * settings_.min_width_m) / edge2;
    const Eigen::Vector3f variance = eigen.eigenvalues().cwiseMax(0.0F);
    Eigen::Map<Eigen::Vector3f>(cell.mean.data()) = mean;
    cell.kind = Surface::Kind::none;
    if (variance[0] < thin2 && variance[1] > wide2 && variance[1] > 9 * variance[0]) {
        cell.kind = Surface::Kind::plane;
        Eigen::Map<Eigen::Vector3f>(cell.direction.data()) = eigen.eigenvectors().col(0);
        cell.variance = variance[0] * edge2;
    } else if (variance[1] < thin2 && variance[2] > wide2 && variance[2] > 9 * variance[1] &&
               std::abs(eigen.eigenvectors()(2, 2)) > upright) {
        cell.kind = Surface::Kind::edge;
        Eigen::Map<Eigen::Vector3f>(cell.direction.data()) = eigen.eigenvectors().col(2);
        cell.variance = variance[1] * edge2;
    }
}

bool SurfaceMap::find(const Eigen::Vector3d& p_map_m, Surface::Kind& kind, Eigen::Vector3f& direction,
                      Eigen::Vector3f& offset_m, float& variance_m2) const {
    for (const Size& size : sizes_) {
        const VoxelIndex index = index_of(size, p_map_m);
        const Cell* cell = find_cell(size, pack(index));
        if (cell == nullptr || cell->kind == Surface::Kind::none) continue;
        kind = cell->kind;
        direction = Eigen::Map<const Eigen::Vector3f>(cell->direction.data());
        variance_m2 = cell->variance;
        offset_m = static_cast<float>(size.edge_m) *
                   (Eigen::Vector3f(static_cast<float>(p_map_m.x() * size.per_edge - index.x - 0.5),
                                    static_cast<float>(p_map_m.y() * size.per_edge - index.y - 0.5),
                                    static_cast<float>(p_map_m.z() * size.per_edge - index.z - 0.5)) -
                    Eigen::Map<const Eigen::Vector3f>(cell->mean.data()));
        return true;
    }
    return false;
}

void SurfaceMap::rebuild(Size& size, std::size_t slots, const VoxelIndex* around, int radius) {
    std::vector<Cell> old(slots);
    old.swap(size.table);
    used_ -= size.used;
    size.used = 0;
    const std::size_t mask = slots - 1;
    for (const Cell& cell : old) {
        if (cell.key == no_voxel) continue;
        if (around != nullptr) {
            const VoxelIndex at = unpack(cell.key);
            if (std::abs(at.x - around->x) > radius || std::abs(at.y - around->y) > radius ||
                std::abs(at.z - around->z) > radius)
                continue;
        }
        std::size_t k = hash(cell.key) & mask;
        while (size.table[k].key != no_voxel) k = (k + 1) & mask;
        size.table[k] = cell;
        ++size.used;
    }
    used_ += size.used;
}

void SurfaceMap::keep_around(const Eigen::Vector3d& p_map_m) {
    for (Size& size : sizes_) {
        const VoxelIndex around = index_of(size, p_map_m);
        rebuild(size, size.table.size(), &around,
                static_cast<int>(settings_.keep_radius_m * size.per_edge) + 1);
    }
}

std::size_t SurfaceMap::bytes() const {
    std::size_t bytes = 0;
    for (const Size& size : sizes_) bytes += size.table.size() * sizeof(Cell);
    return bytes;
}

}  // namespace loopline::lidar_mapping
