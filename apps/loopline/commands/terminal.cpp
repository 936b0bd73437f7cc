#include "commands/terminal.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>

namespace loopline {

std::optional<std::size_t> columns_of(int file_descriptor) {
    winsize window{};
    if (ioctl(file_descriptor, TIOCGWINSZ, &window) != 0 || window.ws_col == 0) return std::nullopt;
    return window.ws_col;
}

void clear_line_on_stderr() {
    if (::isatty(STDERR_FILENO) == 1) std::fputs("\r\033[K", stderr);
}

std::size_t terminal_width() {
    constexpr std::size_t narrowest = 30, widest = 100;
    std::size_t width = columns_of(STDOUT_FILENO).value_or(usual_columns);
    if (const char* columns = std::getenv("COLUMNS"))
        if (const long asked = std::strtol(columns, nullptr, 10); asked > 0)
            width = static_cast<std::size_t>(asked);
    return std::clamp(width, narrowest, widest);
}

std::size_t display_width(const std::string& text) {
    const auto starts_letter = [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; };
    return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), starts_letter));
}

std::string padded(const std::string& text, std::size_t width) {
    return text + std::string(width - std::min(width, display_width(text)), ' ');
}

std::string wrapped(const std::string& text, std::size_t width, std::size_t indent, std::size_t from) {
    std::string result;
    std::size_t column = from;
    bool at_start = true;
    for (std::size_t at = 0; at < text.size();) {
        if (text[at] == '\n' || text[at] == ' ') {
            if (text[at] == '\n') {
                result += '\n';
                at_start = true;
                column = 0;
                if (at + 1 < text.size() && text[at + 1] != '\n') {
                    result += std::string(indent, ' ');
                    column = indent;
                }
            }
            ++at;
            continue;
        }
        const std::size_t end = std::min(text.find_first_of(" \n", at), text.size());
        const std::string word = text.substr(at, end - at);
        if (!at_start && column + 1 + display_width(word) >= width) {
            result += '\n' + std::string(indent, ' ');
            column = indent;
            at_start = true;
        }
        if (!at_start) result += ' ';
        column += display_width(word) + (at_start ? 0 : 1);
        result += word;
        at_start = false;
        at = end;
    }
    return result;
}

std::string plain_message(const std::string& what) {
    std::string text = what;
    // MRPT: "==== MRPT exception ====\nMessage:  TEXT\nLocation: ...\nCall stack backtrace:\n..."
    const std::string head = "Message:";
    if (const auto message = text.find(head);
        text.rfind("==== MRPT exception", 0) == 0 && message != std::string::npos)
        text.erase(0, message + head.size());
    text.erase(std::min({text.find("\nLocation:"), text.find("\nCall stack"), text.size()}));
    std::string line;
    for (const char c : text) {
        const bool blank = c == '\n' || c == ' ' || c == '\t' || c == '\r';
        if (!blank)
            line += c;
        else if (!line.empty() && line.back() != ' ')
            line += ' ';
    }
    while (!line.empty() && line.back() == ' ') line.pop_back();
    return line;
}

}  // namespace loopline
