/// PLY and PCD share their build: a text header that lists the fields of a point, then rows of text or of
/// bytes.
#include "point_files/point_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <map>
#include <sstream>
#include <vector>

#include "api/parameters.h"
#include "point_files/point_rows.h"

namespace loopline {
namespace {

class TextPoints : public PointFile {
 public:
    explicit TextPoints(std::vector<Eigen::Vector3d> points_m) : points_m_(std::move(points_m)) {}
    std::size_t size() const override { return points_m_.size(); }
    void for_each(std::size_t stride, const Use& use) const override {
        for (std::size_t i = 0; i < points_m_.size(); i += stride) use(points_m_[i]);
    }

 private:
    std::vector<Eigen::Vector3d> points_m_;
};

struct Field {
    std::string name;
    Number number = Number::real;
    std::size_t bytes = 4;
    std::size_t count = 1;  ///< values in a row (PCD only)
};

struct Layout {
    std::vector<Field> fields;
    std::uint64_t points = 0;
    bool binary = false;

    std::size_t row_bytes() const {
        std::size_t sum = 0;
        for (const auto& f : fields) sum += f.bytes * f.count;
        return sum;
    }
};

/// Where x, y and z stand: in a binary row, and as numbers of values in a text row.
struct Coordinates {
    std::array<PointColumn, 3> columns;
    std::array<std::size_t, 3> index{};
};

Coordinates coordinates_of(const std::filesystem::path& file, const Layout& layout) {
    Coordinates found;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::string name(1, "xyz"[axis]);
        std::size_t offset = 0, index = 0;
        bool is_there = false;
        for (const auto& field : layout.fields) {
            if (field.name == name) {
                found.columns[axis] = {field.number, field.bytes, offset};
                found.index[axis] = index;
                is_there = true;
            }
            offset += field.bytes * field.count;
            index += field.count;
        }
        if (!is_there) refuse_points(file, "has no field " + name + " per point");
    }
    return found;
}

Eigen::Vector3d point_of_text(const std::string& line, const Coordinates& coordinates) {
    std::istringstream words(line);
    std::vector<std::string> values;
    for (std::string word; words >> word;) values.push_back(word);
    Eigen::Vector3d p = Eigen::Vector3d::Constant(NAN);
    for (std::size_t axis = 0; axis < 3; ++axis)
        if (coordinates.index[axis] < values.size())
            if (const auto value = number_from_text(values[coordinates.index[axis]]))
                p[static_cast<int>(axis)] = *value;
    return p;
}

/// `in` stands behind the header.
std::shared_ptr<const PointFile> points_behind(const std::filesystem::path& file, std::istream& in,
                                               const Layout& layout) {
    const Coordinates coordinates = coordinates_of(file, layout);
    if (layout.binary) {
        PointRows rows;
        rows.file = file;
        rows.begin = static_cast<std::uint64_t>(std::max<std::streamoff>(0, in.tellg()));
        rows.points = layout.points;
        rows.row_bytes = layout.row_bytes();
        rows.axes = coordinates.columns;
        return std::make_shared<RowsOfFile>(std::move(rows));
    }
    std::vector<Eigen::Vector3d> points_m;
    std::string line;
    for (std::uint64_t i = 0; i < layout.points; ++i) {
        if (!std::getline(in, line))
            refuse_points(file, "ends after " + std::to_string(i) + " of " + std::to_string(layout.points) +
                                    " points; it was not written to its end");
        points_m.push_back(point_of_text(line, coordinates));
    }
    return std::make_shared<TextPoints>(std::move(points_m));
}

std::ifstream opened(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    if (!in) refuse_points(file, "can't be read");
    return in;
}

/// The next header line without a carriage return.
bool header_line(std::istream& in, std::string& line) {
    if (!std::getline(in, line)) return false;
    if (!line.empty() && line.back() == '\r') line.pop_back();
    return line.size() < 4096;
}

}  // namespace

std::shared_ptr<const PointFile> ply_file(const std::filesystem::path& file) {
    static const std::map<std::string, std::pair<Number, std::size_t>> types = {
        {"char", {Number::signed_integer, 1}},
        {"int8", {Number::signed_integer, 1}},
        {"uchar", {Number::unsigned_integer, 1}},
        {"uint8", {Number::unsigned_integer, 1}},
        {"short", {Number::signed_integer, 2}},
        {"int16", {Number::signed_integer, 2}},
        {"ushort", {Number::unsigned_integer, 2}},
        {"uint16", {Number::unsigned_integer, 2}},
        {"int", {Number::signed_integer, 4}},
        {"int32", {Number::signed_integer, 4}},
        {"uint", {Number::unsigned_integer, 4}},
        {"uint32", {Number::unsigned_integer, 4}},
        {"float", {Number::real, 4}},
        {"float32", {Number::real, 4}},
        {"double", {Number::real, 8}},
        {"float64", {Number::real, 8}}};
    auto in = opened(file);
    std::string line;
    if (!header_line(in, line) || line != "ply") refuse_points(file, "is not a PLY file");
    Layout layout;
    std::string element;
    bool ended = false;
    while (!ended && header_line(in, line)) {
        std::istringstream words(line);
        std::string key, first, second;
        words >> key >> first >> second;
        if (key == "format") {
            if (first != "ascii" && first != "binary_little_endian")
                refuse_points(
                    file, "is in the PLY format " + first + "; ascii and binary_little_endian can be read");
            layout.binary = first != "ascii";
        } else if (key == "element") {
            if (element.empty() && first != "vertex") refuse_points(file, "does not begin with its vertices");
            element = first;
            if (first == "vertex")
                layout.points =
                    static_cast<std::uint64_t>(std::max(0.0, number_from_text(second).value_or(0)));
        } else if (key == "property" && element == "vertex") {
            const auto type = types.find(first);
            if (type == types.end())
                refuse_points(file, "has a vertex property of type " + first + ", which can't be read");
            layout.fields.push_back({second, type->second.first, type->second.second, 1});
        }
        ended = key == "end_header";
    }
    if (!ended) refuse_points(file, "ends inside its header");
    return points_behind(file, in, layout);
}

std::shared_ptr<const PointFile> pcd_file(const std::filesystem::path& file) {
    auto in = opened(file);
    Layout layout;
    std::string line, data;
    while (data.empty() && header_line(in, line)) {
        if (line.empty() || line[0] == '#') continue;
        std::istringstream words(line);
        std::string key, word;
        words >> key;
        for (std::size_t i = 0; words >> word; ++i) {
            const double number = number_from_text(word).value_or(0);
            if (key == "FIELDS") layout.fields.push_back({word, Number::real, 4, 1});
            if (key == "POINTS") layout.points = static_cast<std::uint64_t>(std::max(0.0, number));
            if (key == "DATA") data = word;
            if (i >= layout.fields.size()) continue;
            Field& field = layout.fields[i];
            if (key == "SIZE")
                field.bytes =
                    number == 1 || number == 2 || number == 8 ? static_cast<std::size_t>(number) : 4;
            if (key == "TYPE")
                field.number = word == "I"   ? Number::signed_integer
                               : word == "U" ? Number::unsigned_integer
                                             : Number::real;
            if (key == "COUNT")
                field.count = number >= 1 && number < 1e5 ? static_cast<std::size_t>(number) : 1;
        }
    }
    if (layout.fields.empty() || data.empty()) refuse_points(file, "is not a PCD file");
    if (data != "ascii" && data != "binary")
        refuse_points(file, "has PCD data of the kind " + data + "; ascii and binary can be read");
    layout.binary = data == "binary";
    return points_behind(file, in, layout);
}

std::shared_ptr<const PointFile> open_point_file(const std::filesystem::path& file) {
    const auto extension = file.extension();
    return extension == ".ply" ? ply_file(file) : extension == ".las" ? las_file(file) : pcd_file(file);
}

}  // namespace loopline
