/// The pictures as files.
#include <iostream>
#include <opencv2/imgcodecs.hpp>

#include "commands/command.h"
#include "output/output_file.h"
#include "render/cloud_views.h"
#include "render/earth_views.h"
#include "render/picture_file.h"
#include "render/plan_views.h"
#include "render/render.h"
#include "render/spatial_scene.h"
#include "render/spatial_views.h"
#include "render/survey_views.h"

namespace loopline {

void write_png(const cv::Mat& picture, const std::filesystem::path& file) {
    std::vector<unsigned char> bytes;
    cv::imencode(".png", picture, bytes, {cv::IMWRITE_PNG_COMPRESSION, 7});
    write_whole_file(file, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

void render_picture(const SceneContent& content, View view, PictureSize size,
                    const std::filesystem::path& png) {
    cv::Mat picture;
    switch (view) {
        case View::top:
            picture = content.cloud ? draw_cloud_top(content, size) : draw_top_view(content, size);
            break;
        case View::axonometric:
            picture =
                content.cloud ? draw_cloud_axonometric(content, size) : draw_axonometric_view(content, size);
            break;
        case View::follow:
            picture = draw_follow_view(content, size);
            break;
        case View::before_after:
            picture = draw_before_after(content, size);
            break;
        case View::survey_top:
            picture = draw_survey_top(content, size);
            break;
        case View::survey_axonometric:
            picture = draw_survey_axonometric(content, size);
            break;
    }
    write_png(picture, png);
}

std::vector<std::filesystem::path> write_snapshots(const SceneContent& content,
                                                   const std::filesystem::path& folder) {
    const std::pair<View, const char*> views[] = {{View::top, "top.png"},
                                                  {View::axonometric, "axonometric.png"},
                                                  {View::before_after, "before_after.png"},
                                                  {View::survey_top, "survey_top.png"},
                                                  {View::survey_axonometric, "survey_axonometric.png"}};
    std::vector<std::filesystem::path> files;
    std::filesystem::create_directories(folder);
    for (const auto& [view, name] : views) {
        if (view == View::before_after && content.odometry_path.empty() && content.points_odometry_m.empty())
            continue;
        const bool of_survey = view == View::survey_top || view == View::survey_axonometric;
        if (of_survey && content.surveys.empty()) continue;
        try {
            const bool of_cloud = content.cloud && (view == View::top || view == View::axonometric);
            render_picture(content, view,
                           of_survey  ? survey_picture_size(content)
                           : of_cloud ? cloud_picture_size(content, view == View::top)
                                      : PictureSize{},
                           folder / name);
            files.push_back(folder / name);
        } catch (const CommandError& error) {
            // Without a working OpenGL the plans are still worth having.
            if (view != View::axonometric) throw;
            std::cerr << "loopline: " << error.what() << '\n';
        }
    }
    return files;
}

std::vector<std::filesystem::path> write_earth_pictures(const RunRecord& record,
                                                        const EvaluationReference* reference,
                                                        const SceneContent& map,
                                                        const std::filesystem::path& folder) {
    constexpr PictureSize plan{1280, 1040}, heights{1280, 560}, errors{1280, 1200};
    std::vector<std::filesystem::path> files;
    const auto content = earth_content(record, reference, map.title);
    if (!content) return files;
    const auto write = [&](const char* name, const cv::Mat& picture) {
        files.push_back(folder / name);
        write_png(picture, files.back());
    };
    std::filesystem::create_directories(folder);
    write("earth_plan.png", draw_earth_plan(*content, map, plan));
    write("earth_height.png", draw_earth_heights(*content, heights));
    if (content->has_truth) write("earth_error.png", draw_earth_errors(*content, errors));
    return files;
}

void write_3d_scene(const SceneContent& content, const std::filesystem::path& file) {
    SceneSizes sizes = sizes_for_overview(content);
    sizes.most_points = 2'000'000;
    auto scene = make_spatial_scene(content, sizes);
    scene->getViewport()->setCustomBackgroundColor({1.f, 1.f, 1.f});
    auto partial = file;
    partial.replace_filename("." + file.filename().string() + ".partial");
    std::error_code error;
    bool saved = false;
    try {
        saved = scene->saveToFile(partial.string());
    } catch (const std::exception&) {
        // MRPT throws for a folder that is not there; the sentence below is for both.
    }
    if (saved) std::filesystem::rename(partial, file, error);
    if (!saved || error)
        throw CommandError(exit_configuration,
                           "Can't write " + file.string() + "; is the folder there and writable?");
}

}  // namespace loopline
