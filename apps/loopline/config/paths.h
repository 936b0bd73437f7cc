/// Files and folders that a configuration names, and those that the program finds itself.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace loopline {

/// The running program's own file (/proc/self/exe).
std::filesystem::path program_file();

/// The folder of downloaded logs that ${LOOPLINE_DATA} stands for: the environment variable, else
/// ../shared/data beside the working directory, else beside the source tree that the program was built in;
/// `nullopt` if there is none.
std::optional<std::filesystem::path> data_folder();

/// A path with its ${NAME}s replaced, absolute and normal. `problem` is a clause that fits after the key, or
/// empty.
struct ExpandedPath {
    std::string path;
    std::string problem;
};

/// ${NAME} is the environment variable, ${LOOPLINE_DATA} is data_folder(); a relative path is taken from
/// `base`. The empty text stays empty.
ExpandedPath expand_path(const std::string& text, const std::filesystem::path& base);

}  // namespace loopline
