/// The .ini reader: sections of `key = value`, each with the place it came from. MRPT's reader keeps no line
/// numbers and takes what it can't understand in silence.
///
/// Comments start with `;`, `#` or `//`, at the start of a line or after a blank. Blanks around names and
/// values do not count. A value in double quotes is taken as it stands. A byte-order mark and CRLF line ends
/// are fine.
#pragma once

#include <string>
#include <vector>

#include "config/problems.h"

namespace loopline {

struct IniEntry {
    std::string key;
    std::string value;
    /// As `value`, but `;` opened no comment: for lists that `;` separates.
    std::string list_value;
    Origin origin;
    bool from_command_line = false;
};

struct IniSection {
    std::string name;
    Origin origin;
    std::vector<IniEntry> entries;

    IniEntry* find(const std::string& key);
};

struct IniFile {
    std::string path;
    std::vector<IniSection> sections;
    std::vector<std::string> repeatable;  ///< "section.key": what may stand several times
    std::vector<Problem> problems;        ///< what could not be understood, and what stands there twice

    IniSection* find(const std::string& section);
};

/// Never throws: a file that can't be read is a problem in the result.
IniFile read_ini_file(const std::string& path, const std::vector<std::string>& repeatable = {});
/// The same for text in memory; `path` is for the sentences.
IniFile parse_ini_text(const std::string& text, const std::string& path,
                       const std::vector<std::string>& repeatable = {});

/// Every key of `overlay` takes the place of the same key, or is added. What is wrong with the overlay goes
/// to the file's problems.
void apply_overlay(IniFile& file, const IniFile& overlay);

/// `section.key=value` from the command line: replaces the entry (all of them, if the key stands several
/// times), or adds it. The last one counts. What is wrong with its form goes to the file's problems.
void apply_override(IniFile& file, const std::string& assignment);

/// The text of `key = value` from which `value` reads back: in quotes where it needs them.
std::string ini_assignment(const std::string& key, const std::string& value);

}  // namespace loopline
