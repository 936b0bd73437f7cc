/// What another program needs in its environment to load our plugins.
#pragma once

#include <fstream>
#include <string>
#include <vector>

namespace loopline::test {

/// A program without AddressSanitizer loads a plugin that has it only if the sanitizer's own library comes
/// first: the one that this process has loaded, if any.
inline std::vector<std::string> environment_of_our_plugins() {
    std::ifstream maps("/proc/self/maps");
    for (std::string line; std::getline(maps, line);)
        if (line.find("/libasan.so") != std::string::npos)
            return {"LD_PRELOAD=" + line.substr(line.find('/')), "ASAN_OPTIONS=detect_leaks=0"};
    return {};
}

}  // namespace loopline::test
