/// PLY and PCD share their build: a text header that lists the fields of a point, then rows of text or of
/// bytes.
#include "render/point_files.h"

#include <cstdint>
#include <cstring>
#include <fstream>
#include <map>
#include <optional>
#include <sstream>

#include "api/parameters.h"
#include "commands/command.h"

namespace loopline {
namespace {

enum class Number { signed_integer, unsigned_integer, real };

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

[[noreturn]] void refuse(const std::filesystem::path& file, const std::string& what) {
    throw CommandError(exit_input_data, file.string() + " " + what + ".");
}

double value_at(const char* bytes, const Field& field) {
    const auto as = [bytes](auto zero) {
        std::memcpy(&zero, bytes, sizeof zero);
        return static_cast<double>(zero);
    };
    if (field.number == Number::real) return field.bytes == 8 ? as(0.0) : as(0.f);
    const bool is_signed = field.number == Number::signed_integer;
    switch (field.bytes) {
        case 1:
            return is_signed ? as(std::int8_t{}) : as(std::uint8_t{});
        case 2:
            return is_signed ? as(std::int16_t{}) : as(std::uint16_t{});
        case 4:
            return is_signed ? as(std::int32_t{}) : as(std::uint32_t{});
        default:
            return is_signed ? as(std::int64_t{}) : as(std::uint64_t{});
    }
}

/// Where x, y and z stand: byte offset in a binary row, number of the value in a text row.
struct Column {
    Field field;
    std::size_t offset_bytes = 0, index = 0;
};

std::vector<Column> coordinate_columns(const std::filesystem::path& file, const Layout& layout) {
    std::vector<Column> columns;
    for (const char* name : {"x", "y", "z"}) {
        std::size_t offset = 0, index = 0;
        std::optional<Column> found;
        for (const auto& field : layout.fields) {
            if (field.name == name) found = Column{field, offset, index};
            offset += field.bytes * field.count;
            index += field.count;
        }
        if (!found) refuse(file, std::string("has no field ") + name + " per point");
        columns.push_back(*found);
    }
    return columns;
}

std::vector<Eigen::Vector3f> read_rows(const std::filesystem::path& file, std::istream& in,
                                       const Layout& layout) {
    const auto columns = coordinate_columns(file, layout);
    std::vector<Eigen::Vector3f> points_m;
    const auto keep = [&points_m](const Eigen::Vector3f& p) {
        if (p.allFinite()) points_m.push_back(p);
    };
    const auto cut = [&](std::uint64_t row) {
        refuse(file, "ends after " + std::to_string(row) + " of " + std::to_string(layout.points) +
                         " points; it was not written to its end");
    };
    if (layout.binary) {
        std::vector<char> row(layout.row_bytes());
        for (std::uint64_t i = 0; i < layout.points; ++i) {
            if (!in.read(row.data(), static_cast<std::streamsize>(row.size()))) cut(i);
            Eigen::Vector3f p;
            for (int axis = 0; axis < 3; ++axis)
                p[axis] = static_cast<float>(
                    value_at(row.data() + columns[axis].offset_bytes, columns[axis].field));
            keep(p);
        }
        return points_m;
    }
    std::string line;
    for (std::uint64_t i = 0; i < layout.points; ++i) {
        if (!std::getline(in, line)) cut(i);
        std::istringstream words(line);
        std::vector<std::string> values;
        for (std::string word; words >> word;) values.push_back(word);
        Eigen::Vector3f p = Eigen::Vector3f::Constant(NAN);
        for (int axis = 0; axis < 3; ++axis)
            if (columns[axis].index < values.size())
                if (const auto value = number_from_text(values[columns[axis].index]))
                    p[axis] = static_cast<float>(*value);
        keep(p);
    }
    return points_m;
}

std::ifstream opened(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    if (!in) refuse(file, "can't be read");
    return in;
}

/// The next header line without a carriage return.
bool header_line(std::istream& in, std::string& line) {
    if (!std::getline(in, line)) return false;
    if (!line.empty() && line.back() == '\r') line.pop_back();
    return line.size() < 4096;
}

}  // namespace

std::vector<Eigen::Vector3f> read_ply_points(const std::filesystem::path& file) {
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
    if (!header_line(in, line) || line != "ply") refuse(file, "is not a PLY file");
    Layout layout;
    std::string element;
    bool ended = false;
    while (!ended && header_line(in, line)) {
        std::istringstream words(line);
        std::string key, first, second;
        words >> key >> first >> second;
        if (key == "format") {
            if (first != "ascii" && first != "binary_little_endian")
                refuse(file,
                       "is in the PLY format " + first + "; ascii and binary_little_endian can be read");
            layout.binary = first != "ascii";
        } else if (key == "element") {
            if (element.empty() && first != "vertex") refuse(file, "does not begin with its vertices");
            element = first;
            if (first == "vertex")
                layout.points =
                    static_cast<std::uint64_t>(std::max(0.0, number_from_text(second).value_or(0)));
        } else if (key == "property" && element == "vertex") {
            const auto type = types.find(first);
            if (type == types.end())
                refuse(file, "has a vertex property of type " + first + ", which can't be read");
            layout.fields.push_back({second, type->second.first, type->second.second, 1});
        }
        ended = key == "end_header";
    }
    if (!ended) refuse(file, "ends inside its header");
    return read_rows(file, in, layout);
}

std::vector<Eigen::Vector3f> read_pcd_points(const std::filesystem::path& file) {
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
    if (layout.fields.empty() || data.empty()) refuse(file, "is not a PCD file");
    if (data != "ascii" && data != "binary")
        refuse(file, "has PCD data of the kind " + data + "; ascii and binary can be read");
    layout.binary = data == "binary";
    return read_rows(file, in, layout);
}

}  // namespace loopline
