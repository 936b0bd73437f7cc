#include "importers/csv_table.h"

#include <algorithm>
#include <stdexcept>

#include "api/parameters.h"

namespace loopline::csv {
namespace {

bool is_blank(char c) {
    return c == ' ' || c == '\t' || c == '\r';
}

/// Without blanks around it, and without double quotes.
std::string_view bare(std::string_view cell) {
    while (!cell.empty() && is_blank(cell.front())) cell.remove_prefix(1);
    while (!cell.empty() && is_blank(cell.back())) cell.remove_suffix(1);
    if (cell.size() >= 2 && cell.front() == '"' && cell.back() == '"') cell = cell.substr(1, cell.size() - 2);
    return cell;
}

bool is_number(std::string_view cell) {
    const std::string text(cell);
    return number_from_text(text) || text == "nan" || text == "NaN" || text == "inf" || text == "-inf";
}

/// "az (forward, right, down)" without what stands in brackets.
std::string without_brackets(const std::string& name) {
    const auto open = name.find_first_of("([");
    return open == std::string::npos || open == 0 ? name : std::string(bare(name.substr(0, open)));
}

}  // namespace

Table::Table(const std::string& path) : path_(path), stream_(path, std::ios::binary) {
    if (!stream_) throw std::runtime_error("can't read " + path);
    std::string first;
    do {  // a header may look like a comment: it is the last line of those before the numbers
        if (!read_line()) throw std::runtime_error(path + " has no line of numbers; give a table with one");
        if (line_[0] == '#' || line_[0] == '%') first = line_.substr(1);
    } while (line_[0] == '#' || line_[0] == '%');
    choose_separator();
    split(true);
    const bool numbers = std::all_of(cells_.begin(), cells_.end(),
                                     [](std::string_view cell) { return cell.empty() || is_number(cell); });
    columns_ = cells_.size();
    pending_ = numbers;
    if (!numbers) {
        header_.assign(cells_.begin(), cells_.end());
    } else if (!first.empty()) {
        line_.swap(first);
        split(true);
        if (cells_.size() == columns_) header_.assign(cells_.begin(), cells_.end());
        line_.swap(first);
    }
}

void Table::choose_separator() {
    for (const char candidate : {',', ';', '\t'})
        if (line_.find(candidate) != std::string::npos) {
            separator_ = candidate;
            return;
        }
    separator_ = ' ';
}

std::optional<std::size_t> Table::find(const ColumnChoice& choice) const {
    if (choice.number) return *choice.number < columns_ ? choice.number : std::nullopt;
    for (std::size_t i = 0; i < header_.size(); ++i)
        if (header_[i] == choice.name) return i;
    for (std::size_t i = 0; i < header_.size(); ++i)
        if (without_brackets(header_[i]) == choice.name) return i;
    return std::nullopt;
}

bool Table::read_line() {
    while (std::getline(stream_, line_)) {
        if (++line_number_ == 1 && line_.rfind("\xEF\xBB\xBF", 0) == 0) line_.erase(0, 3);
        if (!std::all_of(line_.begin(), line_.end(), is_blank)) return true;
    }
    return false;
}

bool Table::next() {
    if (!pending_) do {
            if (!read_line()) return false;
        } while (line_[0] == '#' || line_[0] == '%');
    pending_ = false;
    split(false);
    return true;
}

void Table::split(bool brackets_hold) {
    cells_.clear();
    const std::string_view line(line_);
    int depth = 0;
    std::size_t from = 0;
    const auto end_cell = [&](std::size_t to) {
        const std::string_view cell = bare(line.substr(from, to - from));
        if (separator_ != ' ' || !cell.empty()) cells_.push_back(cell);
        from = to + 1;
    };
    for (std::size_t i = 0; i < line.size(); ++i) {
        const char c = line[i];
        if (brackets_hold && (c == '(' || c == '[')) ++depth;
        if (brackets_hold && depth > 0 && (c == ')' || c == ']')) --depth;
        if (depth == 0 && (separator_ == ' ' ? is_blank(c) : c == separator_)) end_cell(i);
    }
    if (depth > 0) return split(false);  // a bracket that nobody closes
    end_cell(line.size());
}

std::string_view Table::cell(std::size_t column) const {
    return column < cells_.size() ? cells_[column] : std::string_view();
}

}  // namespace loopline::csv
