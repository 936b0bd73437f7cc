/// Rows of numbers in a text file, with what a sentence about a wrong one needs.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "api/stamp.h"

namespace loopline {

/// The words of one line of a text file; it refers to them and to the file's name, and does not outlive them.
class TextRow {
 public:
    TextRow(const std::filesystem::path& file, std::size_t line, const std::vector<std::string>& words)
        : file_(file), line_(line), words_(words) {}

    std::size_t size() const { return words_.size(); }
    const std::string& word(std::size_t column) const { return words_[column]; }
    /// Finite; otherwise fail().
    double number(std::size_t column) const;
    /// Seconds, all of their decimals kept to the nanosecond; otherwise fail().
    StampNs stamp(std::size_t column) const;
    /// Throws CommandError(exit_input_data) "FILE:LINE: ".
    [[noreturn]] void fail(const std::string& sentence) const;

 private:
    const std::filesystem::path& file_;
    std::size_t line_;
    const std::vector<std::string>& words_;
};

/// Calls `take` for every line but those that are blank or begin with "#" or "%". Throws
/// CommandError(exit_input_data) if the file can't be read; `what` says what it should have been ("the
/// relations").
void for_each_row(const std::filesystem::path& file, const std::string& what,
                  const std::function<void(const TextRow&)>& take);

/// The same with the cells of a CSV file, separated by "," or ";", for words; empty cells are left out.
void for_each_csv_row(const std::filesystem::path& file, const std::string& what,
                      const std::function<void(const TextRow&)>& take);

/// 0 if there is no row.
std::size_t columns_of_first_row(const std::filesystem::path& file, const std::string& what);

}  // namespace loopline
