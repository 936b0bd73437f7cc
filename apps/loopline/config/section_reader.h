/// Takes the values of one .ini section into the variables that its parameters are bound to.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "api/module.h"
#include "config/ini_file.h"
#include "config/problems.h"

namespace loopline {

/// A section that there could be.
struct DeclaredSection {
    Configurable::Ptr owner;  ///< null for the host's own
    ParameterTable table;
    bool used = false;  ///< the host's own, or named in [run]
};

using DeclaredSections = std::map<std::string, DeclaredSection>;  ///< by name

std::vector<std::string> names_of(const DeclaredSections& sections);

/// Every key of `written` is looked up, its value read and checked; what is wrong goes to `problems`.
/// Relative paths are taken from `ini_folder`, those of the command line from the working directory.
void read_section(const IniSection& written, const DeclaredSections& declared,
                  const std::filesystem::path& ini_folder, std::vector<Problem>& problems);

}  // namespace loopline
