#include "config/ini_file.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

namespace loopline {
namespace {

constexpr std::size_t largest_file_bytes = 4 << 20;

bool is_blank(char c) {
    return c == ' ' || c == '\t';
}

std::string trimmed(const std::string& text) {
    const auto first = text.find_first_not_of(" \t"), last = text.find_last_not_of(" \t");
    return first == std::string::npos ? std::string() : text.substr(first, last - first + 1);
}

/// Where a comment starts at or after `from`; the end of the line if none does.
std::size_t comment_start(const std::string& line, std::size_t from, bool semicolon) {
    for (std::size_t i = from; i < line.size(); ++i) {
        const bool opens = line[i] == '#' || (semicolon && line[i] == ';') || line.compare(i, 2, "//") == 0;
        if (opens && (i == 0 || is_blank(line[i - 1]))) return i;
    }
    return line.size();
}

/// The value that starts at `from`: quoted, or up to a comment.
std::string value_at(const std::string& line, std::size_t from, bool semicolon) {
    const std::size_t first = std::min(line.find_first_not_of(" \t", from), line.size());
    if (first < line.size() && line[first] == '"') {
        const std::size_t close = line.find('"', first + 1);
        if (close != std::string::npos &&
            trimmed(line.substr(close + 1, comment_start(line, close + 1, true) - close - 1)).empty())
            return line.substr(first + 1, close - first - 1);
    }
    return trimmed(line.substr(from, comment_start(line, from, semicolon) - from));
}

std::string shortened(const std::string& text) {
    return text.size() <= 40 ? text : text.substr(0, 37) + "...";
}

/// What is no text: the sentence about it, or nothing.
std::string binary_complaint(const std::string& line) {
    for (const char c : line) {
        const auto byte = static_cast<unsigned char>(c);
        if (byte == 0)
            return "is not a text file (it holds zero bytes; if an editor wrote it as UTF-16, save it as "
                   "UTF-8)";
        if (byte < 32 && byte != '\t' && byte != '\f')
            return "is not a text file (it holds control characters)";
    }
    return {};
}

class Parser {
 public:
    explicit Parser(IniFile& file) : file_(file) {}

    /// False where reading on makes no sense.
    bool take(const std::string& line, int number) {
        origin_ = {file_.path + ":" + std::to_string(number), number};
        if (const auto complaint = binary_complaint(line); !complaint.empty()) {
            report(complaint);
            return false;
        }
        const std::string content = trimmed(line.substr(0, comment_start(line, 0, true)));
        if (content.empty()) return true;
        if (content.front() == '[')
            take_header(content);
        else
            take_entry(line, content);
        return true;
    }

 private:
    void report(const std::string& sentence) { file_.problems.emplace_back(origin_, sentence); }

    void take_header(const std::string& content) {
        section_ = nullptr;
        skipping_ = true;  // what stands below a broken header would only repeat the complaint
        if (content.back() != ']' || content.find(']') + 1 != content.size())
            return report("the section header " + shortened(content) + " does not end in \"]\"");
        const std::string name = trimmed(content.substr(1, content.size() - 2));
        if (name.empty()) return report("the section header [] has no name");
        if (const auto* first = file_.find(name))
            return report("the section [" + name + "] stands there twice (first in line " +
                          std::to_string(first->origin.line) + "); join the two");
        file_.sections.push_back({name, origin_, {}});
        section_ = &file_.sections.back();
        skipping_ = false;
    }

    void take_entry(const std::string& line, const std::string& content) {
        const std::size_t equals = line.find('=');
        const bool assigns = content.find('=') != std::string::npos;
        if (!assigns)
            return report("\"" + shortened(content) + "\" is neither [section], key = value nor a comment");
        const std::string key = trimmed(line.substr(0, equals));
        if (key.empty()) return report("there is no key before \"=\"");
        if (skipping_) return;
        if (!section_) return report("\"" + shortened(key) + "\" stands before the first [section]");
        if (const auto* first = section_->find(key); first && !may_repeat(key))
            return report("[" + section_->name + "] " + key + " stands there twice (first in line " +
                          std::to_string(first->origin.line) + "); remove one");
        section_->entries.push_back(
            {key, value_at(line, equals + 1, true), value_at(line, equals + 1, false), origin_});
    }

    bool may_repeat(const std::string& key) const {
        const std::string name = section_->name + "." + key;
        return std::find(file_.repeatable.begin(), file_.repeatable.end(), name) != file_.repeatable.end();
    }

    IniFile& file_;
    Origin origin_;
    IniSection* section_ = nullptr;
    bool skipping_ = false;
};

}  // namespace

IniEntry* IniSection::find(const std::string& key) {
    const auto found =
        std::find_if(entries.begin(), entries.end(), [&](const auto& e) { return e.key == key; });
    return found == entries.end() ? nullptr : &*found;
}

IniSection* IniFile::find(const std::string& section) {
    const auto found =
        std::find_if(sections.begin(), sections.end(), [&](const auto& s) { return s.name == section; });
    return found == sections.end() ? nullptr : &*found;
}

IniFile parse_ini_text(const std::string& text, const std::string& path,
                       const std::vector<std::string>& repeatable) {
    IniFile file;
    file.path = path;
    file.repeatable = repeatable;
    Parser parser(file);
    std::size_t begin = text.rfind("\xEF\xBB\xBF", 0) == 0 ? 3 : 0;
    for (int number = 1; begin < text.size(); ++number) {
        const std::size_t end = std::min(text.find('\n', begin), text.size());
        std::string line = text.substr(begin, end - begin);
        if (!line.empty() && line.back() == '\r') line.pop_back();
        if (!parser.take(line, number)) break;
        begin = end + 1;
    }
    return file;
}

IniFile read_ini_file(const std::string& path, const std::vector<std::string>& repeatable) {
    const auto unreadable = [&](const std::string& why) {
        IniFile file;
        file.path = path;
        file.problems.emplace_back(Origin{path, 1}, why);
        return file;
    };
    std::error_code ignored;
    if (path.empty()) return unreadable("the name of the .ini file is empty");
    if (std::filesystem::is_directory(path, ignored))
        return unreadable("this is a folder; name the .ini file in it");
    std::ifstream stream(path, std::ios::binary);
    if (!stream)
        return unreadable(errno == ENOENT ? "there is no such file"
                                          : std::string("can't be read: ") + std::strerror(errno));
    std::string text;
    std::array<char, 4096> part{};
    while (text.size() <= largest_file_bytes && (stream.read(part.data(), part.size()), stream.gcount() > 0))
        text.append(part.data(), static_cast<std::size_t>(stream.gcount()));
    if (stream.bad()) return unreadable("can't be read to its end");
    if (text.size() > largest_file_bytes && text.find('\0') == std::string::npos)
        return unreadable(
            "this is longer than 4 MB, which no .ini file is; give the .ini, and the log by --rawlog");
    return parse_ini_text(text, path, repeatable);
}

void apply_overlay(IniFile& file, const IniFile& overlay) {
    file.problems.insert(file.problems.end(), overlay.problems.begin(), overlay.problems.end());
    for (const IniSection& over : overlay.sections) {
        IniSection* section = file.find(over.name);
        if (!section) {
            file.sections.push_back(over);
            continue;
        }
        auto& entries = section->entries;
        const auto is_replaced = [&over](const IniEntry& entry) {
            return std::any_of(over.entries.begin(), over.entries.end(),
                               [&entry](const IniEntry& by) { return by.key == entry.key; });
        };
        entries.erase(std::remove_if(entries.begin(), entries.end(), is_replaced), entries.end());
        entries.insert(entries.end(), over.entries.begin(), over.entries.end());
    }
}

void apply_override(IniFile& file, const std::string& assignment) {
    const Origin origin{"--set " + assignment, 0};
    const std::size_t equals = std::min(assignment.find('='), assignment.size());
    const std::size_t dot = std::min(assignment.find('.'), equals);
    const std::string section_name = trimmed(assignment.substr(0, dot));
    const std::string key =
        dot < equals ? trimmed(assignment.substr(dot + 1, equals - dot - 1)) : std::string();
    const bool one_line = binary_complaint(assignment).empty();
    if (section_name.empty() || key.empty() || equals == assignment.size() || !one_line) {
        file.problems.emplace_back(origin, "this is not of the form section.key=value");
        return;
    }
    const std::string value = trimmed(assignment.substr(equals + 1));
    IniSection* section = file.find(section_name);
    if (!section) {
        file.sections.push_back({section_name, origin, {}});
        section = &file.sections.back();
    }
    auto& entries = section->entries;
    const auto same_key = [&](const IniEntry& entry) { return entry.key == key; };
    const auto first = std::find_if(entries.begin(), entries.end(), same_key);
    if (first == entries.end()) {
        entries.push_back({key, value, value, origin, true});
        return;
    }
    *first = {key, value, value, origin, true};
    entries.erase(std::remove_if(first + 1, entries.end(), same_key), entries.end());
}

std::string ini_assignment(const std::string& key, const std::string& value) {
    const std::string line = key + " = " + value;
    const bool reads_back =
        value_at(line, key.size() + 2, true) == value && value_at(line, key.size() + 2, false) == value;
    if (value.empty()) return key + " =";
    return reads_back ? line : key + " = \"" + value + "\"";
}

}  // namespace loopline
