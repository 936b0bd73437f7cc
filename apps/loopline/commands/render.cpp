/// loopline render: a picture of a run, or of one file of it.
#include "commands/render.h"

#include <CLI/CLI.hpp>
#include <charconv>
#include <optional>

#include "render/render.h"

namespace loopline {
namespace {

const std::vector<std::pair<std::string, View>> views = {{"top", View::top},
                                                         {"axonometric", View::axonometric},
                                                         {"follow", View::follow},
                                                         {"before_after", View::before_after}};

/// "1280x960"; `nullopt` for anything else and for sizes that are not allowed.
std::optional<PictureSize> size_from_text(const std::string& text) {
    PictureSize size;
    const char* end = text.data() + text.size();
    const auto width = std::from_chars(text.data(), end, size.width_px);
    if (width.ec != std::errc() || width.ptr == end || *width.ptr != 'x') return std::nullopt;
    const auto height = std::from_chars(width.ptr + 1, end, size.height_px);
    if (height.ec != std::errc() || height.ptr != end || !is_allowed(size)) return std::nullopt;
    return size;
}

class RenderCommand : public Command {
 public:
    std::string name() const override { return "render"; }
    std::string sentence() const override {
        return "draws a picture of a run directory, or of one trajectory or map file";
    }

    void declare(CLI::App& app) override {
        app.add_option(
               "source", source_,
               "run directory, or a .tum, .ply, .pcd, .gridmap, map_server .yaml, .simplemap or line .csv")
            ->required()
            ->type_name("RUNDIR|FILE");
        app.add_option("--view", view_,
                       "top, axonometric, follow (behind the vehicle at its last pose) or before_after")
            ->capture_default_str()
            ->type_name("VIEW");
        app.add_option("--size", size_, "width and height in pixels")
            ->capture_default_str()
            ->type_name("WxH");
        app.add_option("--out", out_, "picture to write")->required()->type_name("P.png");
    }

    ExitCode run() override {
        std::optional<View> view;
        std::string known;
        for (const auto& [name, value] : views) {
            if (name == view_) view = value;
            known += (known.empty() ? "" : &name == &views.back().first ? " or " : ", ") + name;
        }
        if (!view)
            throw CommandError(exit_configuration,
                               "--view " + view_ + " is not a view; write " + known + ".");
        const auto size = size_from_text(size_);
        if (!size)
            throw CommandError(exit_configuration,
                               "--size " + size_ +
                                   " is not a picture size; write WIDTHxHEIGHT in pixels, each from " +
                                   std::to_string(smallest_picture_px) + " to " +
                                   std::to_string(largest_picture_px) + ", such as 1280x960.");
        if (std::filesystem::path(out_).extension() != ".png")
            throw CommandError(exit_configuration,
                               "--out " + out_ + " must end in .png, the only format that is written.");
        render_picture(scene_from_path(source_), *view, *size, out_);
        return exit_done;
    }

 private:
    std::string source_, view_ = "top", size_ = "1280x960", out_;
};

}  // namespace

std::unique_ptr<Command> make_render_command() {
    return std::make_unique<RenderCommand>();
}

}  // namespace loopline
