/// Text for people: wrapped to the terminal, errors cut to their first sentence.
#pragma once

#include <cstddef>
#include <optional>
#include <string>

namespace loopline {

constexpr std::size_t usual_columns = 80;

/// The width of the terminal behind this file descriptor; nothing if it is no terminal or doesn't know.
std::optional<std::size_t> columns_of(int file_descriptor);

/// Takes the line that the cursor is in off the terminal on standard error, so that a sentence starts on a
/// clean one; nothing in a pipe.
void clear_line_on_stderr();

/// Columns to write in: COLUMNS, else the terminal's own width, else 80; between 30 and 100, where lines stay
/// readable.
std::size_t terminal_width();

/// Letters on the screen: UTF-8 counts by character.
std::size_t display_width(const std::string& text);

/// `text` padded with blanks to `width` letters.
std::string padded(const std::string& text, std::size_t width);

/// Breaks `text` at blanks so that lines end before column `width`. The first line starts where the cursor
/// stands, in column `from`; the others are indented by `indent`. Line breaks in `text` stay. No line break
/// at the end.
std::string wrapped(const std::string& text, std::size_t width, std::size_t indent, std::size_t from);

/// What an exception says, without the stack that MRPT puts behind it, on one line.
std::string plain_message(const std::string& what);

}  // namespace loopline
