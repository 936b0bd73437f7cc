/// What was built with this test program: the same build folder, wherever its own objects come from.
#pragma once

#include <dlfcn.h>

#include <filesystem>
#include <string>

namespace loopline::test {

/// tests/NAME is the test program in it.
inline const std::string& build_folder() {
    static const std::string folder =
        std::filesystem::read_symlink("/proc/self/exe").parent_path().parent_path().string();
    return folder;
}
/// The checkout that it was built from.
inline const std::string& source_folder() {
    static const std::string folder = std::filesystem::read_symlink(build_folder() + "/source").string();
    return folder;
}
inline std::string loopline_program() {
    return build_folder() + "/bin/loopline";
}
inline std::string plugin_folder() {
    return build_folder() + "/lib/loopline";
}
/// Of plugins good and bad, each in a folder for LOOPLINE_PLUGINS.
inline std::string fixture_folder() {
    return build_folder() + "/tests/fixtures";
}

/// The sanitizer tells of what the program then survives, and needs more memory than a limit would leave.
inline bool built_with_address_sanitizer() {
    return ::dlsym(RTLD_DEFAULT, "__asan_init") != nullptr;
}

}  // namespace loopline::test
