#include "config/paths.h"

#include <cstdlib>

namespace loopline {
namespace {

namespace fs = std::filesystem;

std::optional<std::string> variable(const std::string& name) {
    if (name == "LOOPLINE_DATA") {
        const auto folder = data_folder();
        return folder ? std::optional(folder->string()) : std::nullopt;
    }
    const char* value = std::getenv(name.c_str());
    return value ? std::optional<std::string>(value) : std::nullopt;
}

std::string unset_complaint(const std::string& name) {
    if (name == "LOOPLINE_DATA")
        return "needs ${LOOPLINE_DATA}, which is not set, and there is no ../shared/data; set it to the "
               "folder of the "
               "downloaded logs";
    return "needs ${" + name + "}, which is not set in the environment";
}

}  // namespace

fs::path program_file() {
    std::error_code none;
    return fs::read_symlink("/proc/self/exe", none);
}

std::optional<fs::path> data_folder() {
    if (const char* named = std::getenv("LOOPLINE_DATA"); named && *named) return fs::path(named);
    std::error_code none;
    // TREE/build/release/bin/loopline: four levels up is the tree.
    const fs::path tree = program_file().parent_path().parent_path().parent_path().parent_path();
    for (const fs::path& start : {fs::current_path(none), tree}) {
        const fs::path folder = (start / ".." / "shared" / "data").lexically_normal();
        if (fs::is_directory(folder, none)) return folder;
    }
    return std::nullopt;
}

ExpandedPath expand_path(const std::string& text, const fs::path& base) {
    if (text.empty()) return {};
    std::string expanded;
    for (std::size_t at = 0; at < text.size();) {
        const std::size_t open = std::min(text.find("${", at), text.size());
        expanded.append(text, at, open - at);
        if (open == text.size()) break;
        const std::size_t close = text.find('}', open);
        if (close == std::string::npos) return {{}, "has a \"${\" without its \"}\": \"" + text + "\""};
        const std::string name = text.substr(open + 2, close - open - 2);
        const auto value = variable(name);
        if (!value) return {{}, unset_complaint(name)};
        expanded += *value;
        at = close + 1;
    }
    std::error_code none;
    const fs::path absolute_base = fs::absolute(base.empty() ? fs::path(".") : base, none);
    return {(absolute_base / expanded).lexically_normal().string(), {}};
}

}  // namespace loopline
