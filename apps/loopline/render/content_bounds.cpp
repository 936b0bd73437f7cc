/// Bounds that stray points do not stretch.
#include "render/content_bounds.h"

#include <algorithm>
#include <cmath>

namespace loopline {

Bounds bounds_of_path(const std::vector<Pose3>& path) {
    Bounds bounds;
    for (const auto& pose : path) bounds.add(pose.translation_m);
    return bounds;
}

Bounds bounds_of_points(const std::vector<Eigen::Vector3f>& points_m) {
    // A sample of the points is enough for a quantile.
    const std::size_t stride = points_m.size() / 200'000 + 1;
    std::vector<float> values[3];
    for (std::size_t i = 0; i < points_m.size(); i += stride)
        if (points_m[i].allFinite())
            for (int axis = 0; axis < 3; ++axis) values[axis].push_back(points_m[i][axis]);
    Bounds bounds;
    if (values[0].empty()) return bounds;
    const std::size_t outside = values[0].size() * 3 / 200;
    for (int axis = 0; axis < 3; ++axis) {
        auto& v = values[axis];
        std::nth_element(v.begin(), v.begin() + outside, v.end());
        bounds.low_m[axis] = v[outside];
        std::nth_element(v.begin(), v.end() - 1 - outside, v.end());
        bounds.high_m[axis] = v[v.size() - 1 - outside];
    }
    return bounds;
}

Bounds bounds_of_lines(const LineMap& lines) {
    Bounds bounds;
    for (const auto& line : lines)
        for (const auto& end_m : {line.start_m, line.end_m}) bounds.add({end_m.x(), end_m.y(), 0});
    return bounds;
}

Bounds bounds_of_grid(const mrpt::maps::COccupancyGridMap2D& grid) {
    Bounds bounds;
    const int columns = static_cast<int>(grid.getSizeX()), rows = static_cast<int>(grid.getSizeY());
    for (int row = 0; row < rows; ++row) {
        const auto is_known = [&](int column) { return std::abs(grid.getCell(column, row) - 0.5f) > 0.02f; };
        int first = 0, last = columns - 1;
        while (first < columns && !is_known(first)) ++first;
        while (last > first && !is_known(last)) --last;
        if (first == columns) continue;
        bounds.add({grid.idx2x(first), grid.idx2y(row), 0});
        bounds.add({grid.idx2x(last), grid.idx2y(row), 0});
    }
    return bounds;
}

Bounds bounds_of(const SceneContent& content) {
    Bounds bounds = bounds_of_path(content.estimated_path);
    bounds.add(bounds_of_path(content.odometry_path));
    bounds.add(bounds_of_points(content.points_m));
    if (content.lines) bounds.add(bounds_of_lines(*content.lines));
    // A grid reaches as far as single beams do; it only counts where it is all there is.
    if (bounds.empty() && content.grid) bounds = bounds_of_grid(*content.grid);
    return bounds;
}

MapWindow fitting_window(const Bounds& bounds, const Box& box) {
    constexpr double smallest_m = 2, margin = 1.08;
    MapWindow window;
    window.box = box;
    Eigen::Vector2d extent_m = Eigen::Vector2d::Constant(smallest_m);
    if (!bounds.empty()) {
        window.centre_m = bounds.centre_m().head<2>();
        extent_m = bounds.extent_m().head<2>().cwiseMax(smallest_m / 2);
        if (extent_m.maxCoeff() < smallest_m) extent_m.setConstant(smallest_m);
    }
    window.px_per_m = std::min(box.width / extent_m.x(), box.height / extent_m.y()) / margin;
    return window;
}

}  // namespace loopline
