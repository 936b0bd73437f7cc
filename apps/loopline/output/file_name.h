/// Names that modules give, as names of files.
#pragma once

#include <cctype>
#include <string>

namespace loopline {

/// Letters, digits, "-" and "_" stay; a name can't lead out of the folder.
inline std::string as_file_name(std::string name) {
    for (char& c : name)
        if (!std::isalnum(static_cast<unsigned char>(c)) && c != '-' && c != '_') c = '_';
    return name.empty() ? "unnamed" : name;
}

}  // namespace loopline
