#include "evaluate/text_rows.h"

#include <algorithm>
#include <cmath>
#include <fstream>

#include "api/parameters.h"
#include "commands/command.h"

namespace loopline {
namespace {

constexpr const char* blanks = " \t\r\n\v\f";

std::vector<std::string> words_of(const std::string& line) {
    std::vector<std::string> words;
    for (std::size_t at = line.find_first_not_of(blanks); at != std::string::npos;) {
        const std::size_t end = line.find_first_of(blanks, at);
        words.push_back(line.substr(at, end - at));
        at = end == std::string::npos ? end : line.find_first_not_of(blanks, end);
    }
    return words;
}

std::vector<std::string> csv_cells_of(const std::string& line) {
    std::vector<std::string> cells;
    for (std::size_t at = 0; at < line.size();) {
        const std::size_t end = std::min(line.find_first_of(",;", at), line.size());
        const std::string cell = line.substr(at, end - at);
        const std::size_t first = cell.find_first_not_of(blanks);
        if (first != std::string::npos)
            cells.push_back(cell.substr(first, cell.find_last_not_of(blanks) - first + 1));
        at = end + 1;
    }
    return cells;
}

using Split = std::vector<std::string>(const std::string&);

void for_each_line(const std::filesystem::path& file, const std::string& what, Split* split,
                   const std::function<void(const TextRow&)>& take) {
    std::ifstream in(file);
    std::error_code ignored;
    if (!in || !std::filesystem::is_regular_file(file, ignored))
        throw CommandError(exit_input_data,
                           "can't read " + what + " " + file.string() + ": there is no such file");
    std::string line;
    for (std::size_t number = 1; std::getline(in, line); ++number) {
        const auto words = split(line);
        if (words.empty() || words[0][0] == '#' || words[0][0] == '%') continue;
        take(TextRow(file, number, words));
    }
}

/// A damaged file may hold anything: what is quoted in a sentence is short and printable.
std::string quoted(const std::string& word) {
    std::string text = word.substr(0, 40);
    for (char& c : text)
        if (static_cast<unsigned char>(c) < 0x20 || static_cast<unsigned char>(c) > 0x7e) c = '?';
    return "\"" + text + "\"";
}

}  // namespace

void TextRow::fail(const std::string& sentence) const {
    throw CommandError(exit_input_data, file_.string() + ":" + std::to_string(line_) + ": " + sentence);
}

double TextRow::number(std::size_t column) const {
    const auto value = number_from_text(words_[column]);
    if (!value)
        fail("column " + std::to_string(column + 1) + " is no finite number: " + quoted(words_[column]));
    return *value;
}

StampNs TextRow::stamp(std::size_t column) const {
    if (const auto stamp_ns = stamp_from_seconds_text(words_[column])) return *stamp_ns;
    const double seconds = number(column);  // written with an exponent
    if (std::abs(seconds) > 9e9)
        fail("the time " + quoted(words_[column]) + " is no number of seconds since 1970");
    return static_cast<StampNs>(std::llround(seconds * 1e9));
}

void for_each_row(const std::filesystem::path& file, const std::string& what,
                  const std::function<void(const TextRow&)>& take) {
    for_each_line(file, what, words_of, take);
}

void for_each_csv_row(const std::filesystem::path& file, const std::string& what,
                      const std::function<void(const TextRow&)>& take) {
    for_each_line(file, what, csv_cells_of, take);
}

}  // namespace loopline
