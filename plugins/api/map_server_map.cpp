#include "api/map_server_map.h"

#include <mrpt/img/CImage.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <limits>
#include <map>
#include <optional>
#include <sstream>

#include "api/parameters.h"

namespace loopline {
namespace {

struct Description {
    std::string image;
    std::string mode = "trinary";
    bool negate = false;
    double resolution_m = 0, x_m = 0, y_m = 0, yaw_rad = 0;
    double occupied_thresh = 0.65, free_thresh = 0.196;
};

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

/// Thresholds count in all modes; a raw pixel is per cent of occupied, and unknown above a hundred.
MapCell cell_of(const Description& d, int pixel) {
    const int p = d.negate ? 255 - pixel : pixel;
    if (d.mode == "raw" && p > 100) return MapCell::unknown;
    const double occupied = d.mode == "raw" ? p / 100.0 : (255 - p) / 255.0;
    return occupied > d.occupied_thresh ? MapCell::occupied
           : occupied < d.free_thresh   ? MapCell::free
                                        : MapCell::unknown;
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

bool read_map_server_map(const std::filesystem::path& yaml, MapServerMap& map, std::string& problem) {
    const auto refuse = [&problem](const std::string& why) {
        problem = why;
        return false;
    };
    if (!std::filesystem::is_regular_file(yaml)) return refuse("there is no such file");
    const auto d = read_description(yaml);
    if (!d)
        return refuse(
            "image, resolution or the three numbers of origin are missing, or one of its numbers is none");
    if (d->mode != "trinary" && d->mode != "scale" && d->mode != "raw")
        return refuse("its mode is \"" + d->mode + "\"");
    if (!(d->resolution_m > 0) || !std::isfinite(d->resolution_m + d->x_m + d->y_m + d->yaw_rad))
        return refuse("resolution or origin is not a usable number");
    map.image = yaml.parent_path() / d->image;  // an absolute path stays as it is
    const auto picture = read_picture(map.image);
    if (!picture) return refuse("its picture " + map.image.string() + " is missing or damaged");

    map.width = picture->width;
    map.height = picture->height;
    map.resolution_m = d->resolution_m;
    map.T_map_picture = {d->x_m, d->y_m, wrap_to_pi(d->yaw_rad)};
    std::array<float, 256> free_of_pixel{};
    std::array<MapCell, 256> cell_of_pixel{};
    for (int p = 0; p < 256; ++p) {
        free_of_pixel[static_cast<std::size_t>(p)] = free_probability(*d, p);
        cell_of_pixel[static_cast<std::size_t>(p)] = cell_of(*d, p);
    }
    map.free_probability.resize(map.width * map.height);
    map.cells.resize(map.width * map.height);
    for (std::size_t row = 0; row < map.height; ++row) {
        const std::uint8_t* pixels = &picture->pixels[(map.height - 1 - row) * map.width];
        for (std::size_t column = 0; column < map.width; ++column) {
            map.free_probability[map.index(column, row)] = free_of_pixel[pixels[column]];
            map.cells[map.index(column, row)] = cell_of_pixel[pixels[column]];
        }
    }
    return true;
}

}  // namespace loopline
