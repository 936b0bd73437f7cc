/// A table of numbers in a text file, line by line.
#pragma once

#include <cstddef>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "importers/csv_units.h"

namespace loopline::csv {

/// Cells are separated by commas, semicolons, tabs or, where there is none of them, blanks; the first line
/// decides. It is the header if one of its cells is no number, and may begin with "#" or "%"; other lines
/// that do are comments. In the header a separator within brackets separates nothing, as in "az (forward,
/// right, down)", and a name is known with its brackets or without.
class Table {
 public:
    /// Throws std::runtime_error, with one sentence, if the file can't be read or is empty.
    explicit Table(const std::string& path);

    const std::string& path() const { return path_; }
    const std::vector<std::string>& header() const { return header_; }  ///< empty: there is none
    std::size_t columns() const { return columns_; }                    ///< of the first line
    /// Nothing if there is no such column.
    std::optional<std::size_t> find(const ColumnChoice& choice) const;

    /// The next line with cells; false at the end.
    bool next();
    std::size_t line() const { return line_number_; }
    /// Empty if the line is too short.
    std::string_view cell(std::size_t column) const;

 private:
    bool read_line();
    void split(bool brackets_hold);
    void choose_separator();

    std::string path_;
    std::ifstream stream_;
    std::string line_;
    std::size_t line_number_ = 0;
    char separator_ = ',';  ///< ' ' for any number of blanks
    std::vector<std::string_view> cells_;
    std::vector<std::string> header_;
    std::size_t columns_ = 0;
    bool pending_ = false;  ///< the first line is one of numbers, and not yet given
};

}  // namespace loopline::csv
