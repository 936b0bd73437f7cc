/// loopline render: a picture of a run, or of one file of it.
#include "commands/render.h"

#include <CLI/CLI.hpp>
#include <charconv>
#include <optional>

#include "pipeline/read_guard.h"
#include "pipeline/supervisor.h"
#include "render/render.h"

namespace loopline {
namespace {

const std::vector<std::pair<std::string, View>> views = {{"top", View::top},
                                                         {"axonometric", View::axonometric},
                                                         {"follow", View::follow},
                                                         {"before_after", View::before_after},
                                                         {"survey_top", View::survey_top},
                                                         {"survey_axonometric", View::survey_axonometric}};

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

/// Bytes of a file, or of the files in a folder.
std::uint64_t bytes_of(const std::filesystem::path& source) {
    std::error_code ignored;
    if (!std::filesystem::is_directory(source, ignored)) {
        const auto bytes = std::filesystem::file_size(source, ignored);
        return ignored ? 0 : bytes;
    }
    std::uint64_t sum = 0;
    for (const auto& entry : std::filesystem::directory_iterator(source, ignored)) {
        const auto bytes = entry.file_size(ignored);
        if (!ignored) sum += bytes;
    }
    return sum;
}

/// Reads and draws; in a worker process, since damaged bytes can crash MRPT's readers, and what they make of
/// such bytes whatever draws it. For the supervisor, reading is object 0 and drawing object 1.
int render_in_worker(const std::string& source, const Attempt& attempt,
                     const std::function<void(const SceneContent&)>& draw) {
    if (const auto& limit = attempt.rules.limits.front())
        throw CommandError(exit_input_data, limit->objects == 0
                                                ? source + " is damaged (" + limit->reason + ")."
                                                : source + " holds what can't be drawn; is it damaged?");
    ReadGuard guard(attempt.rules.state, 0, bytes_of(source));
    guard.enter(0);
    const SceneContent content = scene_from_path(source);
    guard.leave();
    attempt.rules.state->enter(WorkerState::Stage::reading, 0, 1);
    draw(content);
    return exit_done;
}

class RenderCommand : public Command {
 public:
    std::string name() const override { return "render"; }
    std::string sentence() const override {
        return "draws a picture of a run directory, or of one trajectory or map file";
    }

    void declare(CLI::App& app) override {
        app.add_option("source", source_,
                       "run directory, or a .tum, .ply, .pcd, .las, .gridmap, map_server .yaml, .simplemap "
                       "or line .csv")
            ->required()
            ->type_name("RUNDIR|FILE");
        app.add_option(
               "--view", view_,
               "top, axonometric, follow (behind the vehicle at its last pose), before_after, survey_top or "
               "survey_axonometric")
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
        Supervision supervision;
        supervision.rawlogs = {source_};
        supervision.longest_read = std::chrono::minutes(5);
        return static_cast<ExitCode>(supervise(supervision, [&](const Attempt& attempt) {
            return render_in_worker(source_, attempt, [&](const SceneContent& content) {
                render_picture(content, *view, *size, out_);
            });
        }));
    }

 private:
    std::string source_, view_ = "top", size_ = "1280x960", out_;
};

}  // namespace

std::unique_ptr<Command> make_render_command() {
    return std::make_unique<RenderCommand>();
}

}  // namespace loopline
