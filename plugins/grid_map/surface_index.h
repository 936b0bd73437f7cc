/// The surfaces of a few frames, to match another one with: quickly made and quickly asked, where a grid
/// would not pay.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "api/pose2.h"
#include "grid_map/frame.h"

namespace loopline::grid_map {

class SurfaceIndex {
 public:
    /// `bucket_m`: at least as long as the longest reach that is asked for. `spacing_m`: of the points along
    /// a surface. `slots`: about as many as there will be points, a power of two, 256 or more.
    /// `rough_normals`: a scan knows the directions of surfaces better, as where these come from the cells of
    /// a picture.
    explicit SurfaceIndex(double bucket_m, double spacing_m = 0.05, std::size_t slots = 1024,
                          bool rough_normals = false)
        : per_bucket_(1 / bucket_m), spacing_m_(spacing_m), slots_(slots), rough_normals_(rough_normals) {}
    bool has_rough_normals() const { return rough_normals_; }

    void clear();
    /// Points of a frame at its pose; those without a normal are no surface.
    void add(const Frame& frame, const Pose2& T_map_base);
    /// Once, after the last add().
    void finish();

    /// The surface nearest to a place, averaged with the points that continue it: those that face the same
    /// way and are not much farther, over about the spacing of the points.
    struct Nearby {
        bool found = false;
        float dx_m = 0, dy_m = 0;  ///< from the place to it
        float nx = 0, ny = 0;      ///< its normal, of any length
    };
    /// `normal`: within about 45 degrees of it the surface must face.
    Nearby nearest(double x_m, double y_m, float normal_x, float normal_y, float reach_m) const;

    bool empty() const { return points_.empty(); }

 private:
    struct Range {
        std::uint32_t begin, end;
    };
    /// The points in the bucket of a place and the eight around it, and some that share a slot with these.
    std::array<Range, 3> around(double x_m, double y_m) const;

    int bucket(double v_m) const {
        const double v = v_m * per_bucket_;
        const int i = static_cast<int>(v);
        return i > v ? i - 1 : i;
    }
    /// Neighbours along x are neighbours in memory.
    std::size_t slot_of(int bx, int by) const {
        constexpr std::uint32_t row = 73;
        return (static_cast<std::uint32_t>(bx) + static_cast<std::uint32_t>(by) * row) & (slots_ - 1);
    }

    double per_bucket_, spacing_m_;
    std::size_t slots_;
    bool rough_normals_;
    struct Point {
        float x, y, nx, ny;
    };
    std::vector<Point> points_;           ///< as they were added
    std::vector<float> x_, y_, nx_, ny_;  ///< by slots; those of the first two once more at the end
    std::vector<std::uint32_t> begin_;    ///< of each slot
};

}  // namespace loopline::grid_map
