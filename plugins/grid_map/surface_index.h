/// The surfaces of a few frames, to match another one with: quickly made and quickly asked, where a grid
/// would not pay.
#pragma once

#include <cstdint>
#include <vector>

#include "api/pose2.h"
#include "grid_map/frame.h"

namespace loopline::grid_map {

class SurfaceIndex {
 public:
    /// `bucket_m`: at least as long as the longest reach that is asked for. `spacing_m`: of the points along a
    /// surface. `slots`: about as many as there will be points, a power of two. `rough_normals`: a scan knows
    /// the directions of surfaces better, as where these come from the cells of a picture.
    explicit SurfaceIndex(double bucket_m, double spacing_m = 0.05, std::size_t slots = 1024,
                          bool rough_normals = false)
        : per_bucket_(1 / bucket_m),
          spacing_m_(spacing_m),
          slots_(slots),
          rough_normals_(rough_normals) {}
    bool has_rough_normals() const { return rough_normals_; }
    double spacing_m() const { return spacing_m_; }

    void clear();
    /// Points of a frame at its pose; those without a normal are no surface.
    void add(const Frame& frame, const Pose2& T_map_base);
    /// Once, after the last add().
    void finish();

    struct Point {
        float x, y, nx, ny;
    };
    /// visit(point) for each point in the bucket of a place and the eight around it.
    template <class Visit>
    void near(double x_m, double y_m, const Visit& visit) const {
        const int bx = bucket(x_m), by = bucket(y_m);
        for (int dy = -1; dy <= 1; ++dy)
            for (int dx = -1; dx <= 1; ++dx) {
                // Two buckets may share a slot: then a point far away is visited too.
                const std::size_t slot = slot_of(bx + dx, by + dy);
                for (std::uint32_t k = begin_[slot]; k < begin_[slot + 1]; ++k) visit(sorted_[k]);
            }
    }
    bool empty() const { return sorted_.empty(); }

 private:
    int bucket(double v_m) const {
        const double v = v_m * per_bucket_;
        const int i = static_cast<int>(v);
        return i > v ? i - 1 : i;
    }
    std::size_t slot_of(int bx, int by) const {
        return (static_cast<std::uint32_t>(bx) * 73856093U ^ static_cast<std::uint32_t>(by) * 19349663U) %
               slots_;
    }

    double per_bucket_, spacing_m_;
    std::size_t slots_;
    bool rough_normals_;
    std::vector<Point> points_, sorted_;
    std::vector<std::uint32_t> begin_;
};

}  // namespace loopline::grid_map
