#include "evaluate/text_rows.h"

#include <algorithm>
#include <cmath>
#include <fstream>

#include "api/parameters.h"
#include "commands/command.h"

namespace loopline {
namespace {

bool is_blank(char c) {
    return c == ' ' || (c >= '\t' && c <= '\r');
}

/// Words one after the other into strings that are there already: a file has many lines.
class WordList {
 public:
    void clear() { used_ = 0; }
    void add(const char* first, const char* last) {
        if (used_ == words_.size()) words_.emplace_back();
        words_[used_++].assign(first, last);
    }
    const std::vector<std::string>& words() {
        words_.resize(used_);
        return words_;
    }

 private:
    std::vector<std::string> words_;
    std::size_t used_ = 0;
};

void split_at_blanks(const std::string& line, WordList& words) {
    const char *at = line.data(), *end = at + line.size();
    while (true) {
        at = std::find_if_not(at, end, is_blank);
        if (at == end) return;
        const char* const last = std::find_if(at, end, is_blank);
        words.add(at, last);
        at = last;
    }
}

/// Cells between "," or ";", without the blanks around them; empty ones are left out.
void split_cells(const std::string& line, WordList& words) {
    const char *at = line.data(), *end = at + line.size();
    while (at < end) {
        const char* const separator = std::find_if(at, end, [](char c) { return c == ',' || c == ';'; });
        const char* const first = std::find_if_not(at, separator, is_blank);
        const char* last = separator;
        while (last > first && is_blank(last[-1])) --last;
        if (last > first) words.add(first, last);
        at = separator == end ? end : separator + 1;
    }
}

/// Until `take` says false.
void for_each_line(const std::filesystem::path& file, const std::string& what,
                   void (*split)(const std::string&, WordList&),
                   const std::function<bool(const TextRow&)>& take) {
    std::ifstream in(file);
    std::error_code ignored;
    if (!in || !std::filesystem::is_regular_file(file, ignored))
        throw CommandError(exit_input_data,
                           "can't read " + what + " " + file.string() + ": there is no such file");
    WordList list;
    std::string line;
    for (std::size_t number = 1; std::getline(in, line); ++number) {
        list.clear();
        split(line, list);
        const auto& words = list.words();
        if (words.empty() || words[0][0] == '#' || words[0][0] == '%') continue;
        if (!take(TextRow(file, number, words))) return;
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
    for_each_line(file, what, split_at_blanks, [&take](const TextRow& row) { return take(row), true; });
}

void for_each_csv_row(const std::filesystem::path& file, const std::string& what,
                      const std::function<void(const TextRow&)>& take) {
    for_each_line(file, what, split_cells, [&take](const TextRow& row) { return take(row), true; });
}

std::size_t columns_of_first_row(const std::filesystem::path& file, const std::string& what) {
    std::size_t columns = 0;
    for_each_line(file, what, split_at_blanks, [&columns](const TextRow& row) {
        columns = row.size();
        return false;
    });
    return columns;
}

}  // namespace loopline
