/// Off-screen pictures and the report.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "render/scene_content.h"

namespace loopline {

enum class View { top, axonometric, follow };

struct PictureSize {
    int width_px = 1280;
    int height_px = 960;
};

/// One picture with title, legend and scale bar, as PNG.
void render_picture(const SceneContent& content, View view, PictureSize size, const std::filesystem::path& png);

/// The set that every run writes into `folder` (top, axonometric, before_after), in a fixed order; returns the files.
std::vector<std::filesystem::path> write_snapshots(const SceneContent& content, const std::filesystem::path& folder);

/// MRPT's .3Dscene of the same content.
void write_3d_scene(const SceneContent& content, const std::filesystem::path& file);

/// report.html of a finished run directory: one self-contained page made from the files in it.
void write_report(const std::filesystem::path& run_directory);

}  // namespace loopline
