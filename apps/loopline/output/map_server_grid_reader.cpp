#include <mrpt/img/CImage.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <limits>
#include <map>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "api/parameters.h"
#include "commands/command.h"
#include "output/map_server_grid.h"

namespace loopline {
namespace {

using mrpt::maps::COccupancyGridMap2D;

struct Description {
    std::string image;
    std::string mode = "trinary";
    bool negate = false;
    double resolution_m = 0, x_m = 0, y_m = 0, yaw_rad = 0;
    double occupied_thresh = occupied_threshold, free_thresh = free_threshold;
};

[[noreturn]] void refuse(const std::filesystem::path& yaml, const std::string& why) {
    throw CommandError(exit_input_data, "can't read the grid map " + yaml.string() + ": " + why +
                                            "; give a YAML file as map_server and map_saver have it");
}

std::string trimmed(const std::string& text) {
    constexpr const char* around = " \t\r\"'";
    const auto first = text.find_first_not_of(around);
    return first == std::string::npos ? "" : text.substr(first, text.find_last_not_of(around) - first + 1);
}

/// The part of YAML that such files use: "key: value", "key: [a, b, c]", or the list as "- a" lines below;
/// "#" comments. A list comes out as "a,b,c". By hand, since MRPT's reader prints and leaks on a file that is
/// not YAML.
std::map<std::string, std::string> read_keys(std::istream& in) {
    std::map<std::string, std::string> keys;
    std::string last_key;
    for (std::string line; std::getline(in, line);) {
        line = trimmed(line.substr(0, line.find('#')));
        if (line.rfind("- ", 0) == 0) {
            keys[last_key] += (keys[last_key].empty() ? "" : ",") + trimmed(line.substr(2));
        } else if (const auto colon = line.find(':'); colon != std::string::npos) {
            last_key = trimmed(line.substr(0, colon));
            std::string value = trimmed(line.substr(colon + 1));
            if (value.size() >= 2 && value.front() == '[' && value.back() == ']')
                value = value.substr(1, value.size() - 2);
            keys[last_key] = value;
        }
    }
    return keys;
}

/// Nothing if a key is missing or no number.
std::optional<Description> read_description(const std::filesystem::path& yaml) {
    std::ifstream in(yaml);
    auto keys = read_keys(in);
    Description d;
    d.image = keys["image"];
    if (keys.count("mode")) d.mode = keys["mode"];
    if (keys.count("negate")) d.negate = keys["negate"] != "0" && keys["negate"] != "false";

    std::vector<std::string> origin;
    std::istringstream list(keys["origin"]);
    for (std::string number; std::getline(list, number, ',');) origin.push_back(trimmed(number));
    if (d.image.empty() || origin.size() != 3) return std::nullopt;
    const auto set = [](const std::string& text, double& value) {
        const auto number = number_from_text(text);
        if (number) value = *number;
        return number.has_value();
    };
    const bool good = set(keys["resolution"], d.resolution_m) && set(origin[0], d.x_m) &&
                      set(origin[1], d.y_m) && set(origin[2], d.yaw_rad) &&
                      (!keys.count("occupied_thresh") || set(keys["occupied_thresh"], d.occupied_thresh)) &&
                      (!keys.count("free_thresh") || set(keys["free_thresh"], d.free_thresh));
    return good ? std::optional(d) : std::nullopt;
}

/// Probability that a cell is free, of a pixel of 0 .. 255: map_server's rules, image_loader.cpp.
float free_probability(const Description& d, int pixel) {
    const int p = d.negate ? 255 - pixel : pixel;
    if (d.mode == "raw") return p > 100 ? 0.5f : 1 - static_cast<float>(p) / 100;
    const double occupied = (255 - p) / 255.0;
    if (occupied > d.occupied_thresh) return 0;
    if (occupied < d.free_thresh) return 1;
    if (d.mode == "trinary") return 0.5f;
    return static_cast<float>(1 - (occupied - d.free_thresh) / (d.occupied_thresh - d.free_thresh));
}

struct Picture {
    std::size_t width = 0, height = 0;
    std::vector<std::uint8_t> pixels;  ///< top row first
};

/// Binary PGM of 8 bits. By hand, since OpenCV writes to stderr when one is damaged.
std::optional<Picture> read_pgm(std::istream& in) {
    std::array<std::size_t, 3> header{};  // width, height, largest value
    for (std::size_t& number : header) {
        while ((in >> std::ws) && in.peek() == '#')
            in.ignore(std::numeric_limits<std::streamsize>::max(), '\n');
        in >> number;
    }
    in.get();
    const auto [width, height, most] = header;
    if (!in || width == 0 || height == 0 || width > 65536 || height > 65536 || most != 255)
        return std::nullopt;
    Picture picture{width, height, {}};
    constexpr std::size_t block = 1 << 20;  // memory grows with the file, not with what its header claims
    while (picture.pixels.size() < width * height) {
        const std::size_t at = picture.pixels.size(), part = std::min(block, width * height - at);
        picture.pixels.resize(at + part);
        if (!in.read(reinterpret_cast<char*>(&picture.pixels[at]), static_cast<std::streamsize>(part)))
            return std::nullopt;
    }
    return picture;
}

std::optional<Picture> read_picture(const std::filesystem::path& file) try {
    if (!std::filesystem::is_regular_file(file)) return std::nullopt;
    std::ifstream in(file, std::ios::binary);
    char magic[2] = {};
    if (in.read(magic, 2) && magic[0] == 'P' && magic[1] == '5') return read_pgm(in);
    mrpt::img::CImage image;
    constexpr int as_grey = 0;
    if (!image.loadFromFile(file.string(), as_grey)) return std::nullopt;
    Picture picture{image.getWidth(), image.getHeight(), {}};
    for (std::size_t y = 0; y < picture.height; ++y) {
        const auto* row = image.ptrLine<std::uint8_t>(static_cast<unsigned>(y));
        picture.pixels.insert(picture.pixels.end(), row, row + picture.width);
    }
    return picture;
} catch (const std::exception&) {
    return std::nullopt;
}

}  // namespace

COccupancyGridMap2D::Ptr read_map_server_grid(const std::filesystem::path& yaml) {
    if (!std::filesystem::is_regular_file(yaml)) refuse(yaml, "there is no such file");
    const auto d = read_description(yaml);
    if (!d)
        refuse(yaml,
               "image, resolution or the three numbers of origin are missing, or one of its numbers is none");
    if (d->mode != "trinary" && d->mode != "scale" && d->mode != "raw")
        refuse(yaml, "its mode is \"" + d->mode + "\"");
    if (!(d->resolution_m > 0) || !std::isfinite(d->resolution_m + d->x_m + d->y_m))
        refuse(yaml, "resolution or origin is not a usable number");
    if (std::abs(d->yaw_rad) > 1e-9) refuse(yaml, "its origin is turned, which MRPT's grids can't be");
    const std::filesystem::path image = yaml.parent_path() / d->image;  // an absolute path stays as it is
    const auto picture = read_picture(image);
    if (!picture) refuse(yaml, "its picture " + image.string() + " is missing or damaged");

    std::array<COccupancyGridMap2D::cellType, 256> cell_of_pixel{};
    for (int p = 0; p < 256; ++p)
        cell_of_pixel[static_cast<std::size_t>(p)] = COccupancyGridMap2D::p2l(free_probability(*d, p));
    // MRPT's grids lie on multiples of the resolution.
    const double left_m = std::round(d->x_m / d->resolution_m) * d->resolution_m;
    const double bottom_m = std::round(d->y_m / d->resolution_m) * d->resolution_m;
    const auto right_m = left_m + static_cast<double>(picture->width) * d->resolution_m;
    const auto top_m = bottom_m + static_cast<double>(picture->height) * d->resolution_m;
    auto grid = COccupancyGridMap2D::Create();
    grid->setSize(static_cast<float>(left_m), static_cast<float>(right_m), static_cast<float>(bottom_m),
                  static_cast<float>(top_m), static_cast<float>(d->resolution_m));
    if (grid->getSizeX() != picture->width || grid->getSizeY() != picture->height)
        refuse(yaml, "its origin is too far away for its resolution");
    for (std::size_t row = 0; row < picture->height; ++row) {
        const std::uint8_t* pixels = &picture->pixels[(picture->height - 1 - row) * picture->width];
        auto* cells = grid->getRow(static_cast<int>(row));
        for (std::size_t column = 0; column < picture->width; ++column)
            cells[column] = cell_of_pixel[pixels[column]];
    }
    return grid;
}

}  // namespace loopline
