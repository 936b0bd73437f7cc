/// Pictures inside the page.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>

namespace loopline {

/// A figure with the PNG `path` below `folder`, which leads to the file itself; or where it has more than
/// `most_bytes`, as dense clouds of points have, with a JPEG of it, made smaller until it fits. Empty if it
/// is no picture.
std::string picture_figure(const std::filesystem::path& folder, const std::string& path,
                           const std::string& caption, std::size_t most_bytes);

bool is_snapshot(const std::string& path);
/// N of snapshots/correction_N.png.
std::optional<unsigned> correction_number(const std::string& path);

}  // namespace loopline
