#include "simulation/town/buildings.h"

#include <algorithm>
#include <cmath>

namespace loopline::simulation {
namespace {

constexpr double storey_m = 3;

/// A wall seen from outside: along it to the right, up, and out of it.
struct Front {
    Eigen::Vector3d origin_m, along, out;
    double length_m;

    Eigen::Vector3d at(double along_m, double z_m, double out_m = 0) const {
        return origin_m + along_m * along + out_m * out + z_m * Eigen::Vector3d::UnitZ();
    }
};

Front front_of(const Footprint& footprint, int side) {
    constexpr double x[] = {1, -1, -1, 1}, y[] = {1, 1, -1, -1};
    const Eigen::Vector2d from_m = footprint.corner_m(x[side], y[side]),
                          to_m = footprint.corner_m(x[(side + 1) % 4], y[(side + 1) % 4]);
    const Eigen::Vector2d along = (to_m - from_m).normalized();
    return {{from_m.x(), from_m.y(), 0},
            {along.x(), along.y(), 0},
            {along.y(), -along.x(), 0},
            (to_m - from_m).norm()};
}

struct FrontStyle {
    double bay_m, window_m;   ///< from window to window, and width of one
    double sill_m, lintel_m;  ///< above the floor
    double depth_m;           ///< of windows in the wall
    bool pilasters, balconies;
    Material wall;
};

FrontStyle draw_style(RandomStream& random) {
    FrontStyle style{};
    style.bay_m = random.uniform(2.2, 3.6);
    style.window_m = style.bay_m * random.uniform(0.35, 0.55);
    style.sill_m = random.uniform(0.7, 1);
    style.lintel_m = random.uniform(2.1, 2.5);
    style.depth_m = random.uniform(0.1, 0.3);
    style.pilasters = random.chance(0.4);
    style.balconies = random.chance(0.3);
    style.wall = random.chance(0.6)   ? Material::plaster
                 : random.chance(0.6) ? Material::brick
                                      : Material::concrete;
    return style;
}

void add_rectangle(TriangleMesh& mesh, const Front& front, double from_m, double to_m, double low_m,
                   double high_m, Material material, double out_m = 0) {
    mesh.add_quad(front.at(from_m, low_m, out_m), front.at(to_m, low_m, out_m), front.at(to_m, high_m, out_m),
                  front.at(from_m, high_m, out_m), material);
}

/// The pane, and the four faces between it and the wall.
void add_window(TriangleMesh& mesh, const Front& front, double from_m, double to_m, double low_m,
                double high_m, const FrontStyle& style) {
    const double in_m = -style.depth_m;
    add_rectangle(mesh, front, from_m, to_m, low_m, high_m, Material::glass, in_m);
    const double along_m[] = {from_m, to_m, to_m, from_m}, z_m[] = {low_m, low_m, high_m, high_m};
    for (int i = 0; i < 4; ++i) {
        const int j = (i + 1) % 4;
        mesh.add_quad(front.at(along_m[i], z_m[i]), front.at(along_m[j], z_m[j]),
                      front.at(along_m[j], z_m[j], in_m), front.at(along_m[i], z_m[i], in_m), style.wall);
    }
}

/// What stands out of the wall: three sides, top and bottom.
void add_bay(TriangleMesh& mesh, const Front& front, double from_m, double to_m, double low_m, double high_m,
             double out_m, Material material) {
    add_rectangle(mesh, front, from_m, to_m, low_m, high_m, material, out_m);
    for (const double along_m : {from_m, to_m})
        mesh.add_quad(front.at(along_m, low_m), front.at(along_m, low_m, out_m),
                      front.at(along_m, high_m, out_m), front.at(along_m, high_m), material);
    for (const double z_m : {low_m, high_m})
        mesh.add_quad(front.at(from_m, z_m), front.at(to_m, z_m), front.at(to_m, z_m, out_m),
                      front.at(from_m, z_m, out_m), material);
}

void add_storey(TriangleMesh& mesh, const Front& front, double floor_m, const FrontStyle& style, bool upper) {
    const int bays = std::max(1, static_cast<int>(front.length_m / style.bay_m));
    const double bay_m = front.length_m / bays, low_m = floor_m + style.sill_m,
                 high_m = floor_m + style.lintel_m;
    add_rectangle(mesh, front, 0, front.length_m, floor_m, low_m, style.wall);
    add_rectangle(mesh, front, 0, front.length_m, high_m, floor_m + storey_m, style.wall);
    double wall_from_m = 0;
    for (int i = 0; i < bays; ++i) {
        const double from_m = (i + 0.5) * bay_m - style.window_m / 2, to_m = from_m + style.window_m;
        add_rectangle(mesh, front, wall_from_m, from_m, low_m, high_m, style.wall);
        add_window(mesh, front, from_m, to_m, low_m, high_m, style);
        if (upper && style.balconies && i % 3 == 1)
            add_bay(mesh, front, from_m - 0.4, to_m + 0.4, floor_m, floor_m + 1, 0.9, Material::concrete);
        wall_from_m = to_m;
    }
    add_rectangle(mesh, front, wall_from_m, front.length_m, low_m, high_m, style.wall);
}

}  // namespace

void add_building(TriangleMesh& mesh, const Footprint& footprint, double lowest_m, double highest_m,
                  int storeys, RandomStream& random) {
    const FrontStyle style = draw_style(random);
    const double eaves_m = highest_m + storeys * storey_m;
    for (int side = 0; side < 4; ++side) {
        const Front front = front_of(footprint, side);
        add_rectangle(mesh, front, 0, front.length_m, lowest_m, highest_m, style.wall);
        for (int storey = 0; storey < storeys; ++storey)
            add_storey(mesh, front, highest_m + storey * storey_m, style, storey > 0);
        add_bay(mesh, front, 0, front.length_m, eaves_m - 0.3, eaves_m, 0.35, Material::concrete);
        if (!style.pilasters) continue;
        const int bays = std::max(1, static_cast<int>(front.length_m / style.bay_m));
        for (int i = 0; i <= bays; i += 2) {
            const double along_m = std::clamp(i * front.length_m / bays, 0.2, front.length_m - 0.2);
            add_bay(mesh, front, along_m - 0.2, along_m + 0.2, lowest_m, eaves_m - 0.3, 0.2, style.wall);
        }
    }
    const Front first = front_of(footprint, 0), third = front_of(footprint, 2);
    mesh.add_quad(first.at(0, eaves_m), first.at(first.length_m, eaves_m), third.at(0, eaves_m),
                  third.at(third.length_m, eaves_m), Material::concrete);
}

}  // namespace loopline::simulation
