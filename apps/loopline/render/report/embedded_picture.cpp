#include "render/report/embedded_picture.h"

#include <charconv>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string_view>
#include <vector>

#include "render/report/html.h"

namespace loopline {
namespace {

struct EmbeddedPicture {
    std::string data_url;
    int width_px = 0, height_px = 0;
};

EmbeddedPicture embedded(const std::filesystem::path& file, std::size_t most_bytes) {
    std::ifstream in(file, std::ios::binary);
    const std::string png(std::istreambuf_iterator<char>(in), {});
    cv::Mat picture = cv::imdecode(
        cv::Mat(1, static_cast<int>(png.size()), CV_8UC1, const_cast<char*>(png.data())), cv::IMREAD_COLOR);
    if (png.empty() || picture.empty()) return {};
    const int width_px = picture.cols, height_px = picture.rows;
    if (png.size() <= most_bytes) return {"data:image/png;base64," + html::base64(png), width_px, height_px};
    std::vector<unsigned char> jpeg;
    for (;;) {
        cv::imencode(".jpg", picture, jpeg, {cv::IMWRITE_JPEG_QUALITY, 88});
        if (jpeg.size() <= most_bytes || picture.cols < 400) break;
        cv::resize(picture, picture, {}, 0.75, 0.75, cv::INTER_AREA);
    }
    return {
        "data:image/jpeg;base64," + html::base64({reinterpret_cast<const char*>(jpeg.data()), jpeg.size()}),
        width_px, height_px};
}

/// `text` without `front` and `back`, if it has them.
std::optional<std::string_view> between(std::string_view text, std::string_view front,
                                        std::string_view back) {
    const bool has_both = text.size() >= front.size() + back.size() &&
                          text.substr(0, front.size()) == front &&
                          text.substr(text.size() - back.size()) == back;
    if (!has_both) return std::nullopt;
    return text.substr(front.size(), text.size() - front.size() - back.size());
}

}  // namespace

std::string picture_figure(const std::filesystem::path& folder, const std::string& path,
                           const std::string& caption, std::size_t most_bytes) {
    const EmbeddedPicture picture = embedded(folder / path, most_bytes);
    if (picture.data_url.empty()) return {};
    const std::string text = html::escaped(caption);
    return "<figure><a href=\"" + html::relative_link(path) + "\"><img alt=\"" + text + "\" width=\"" +
           std::to_string(picture.width_px) + "\" height=\"" + std::to_string(picture.height_px) +
           "\" src=\"" + picture.data_url + "\"></a><figcaption>" + text + "</figcaption></figure>\n";
}

bool is_snapshot(const std::string& path) {
    return between(path, "snapshots/", ".png").has_value();
}

std::optional<unsigned> correction_number(const std::string& path) {
    const auto digits = between(path, "snapshots/correction_", ".png");
    unsigned number = 0;
    if (!digits) return std::nullopt;
    const char* end = digits->data() + digits->size();
    const auto [stop, error] = std::from_chars(digits->data(), end, number);
    if (error != std::errc() || stop != end) return std::nullopt;
    return number;
}

}  // namespace loopline
