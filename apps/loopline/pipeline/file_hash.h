/// Identifies an input in the manifest.
#pragma once

#include <string>

namespace loopline {

/// SHA-256 of the file's bytes, in lower-case hexadecimal; empty if the file can't be read.
std::string sha256_of_file(const std::string& path);

}  // namespace loopline
