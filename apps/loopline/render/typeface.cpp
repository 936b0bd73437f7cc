/// Glyphs are rendered by FreeType at their final size, unhinted in x, and blended by coverage.
#include "render/typeface.h"

#include <ft2build.h>
#include FT_FREETYPE_H

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace loopline {
namespace {

constexpr char32_t ellipsis = 0x2026;

/// Code points of UTF-8 text; a broken sequence becomes the replacement character, a control character a
/// space.
std::vector<char32_t> code_points(const std::string& text) {
    std::vector<char32_t> points;
    for (std::size_t i = 0; i < text.size();) {
        const unsigned char lead = text[i++];
        const int more = lead < 0x80       ? 0
                         : lead >> 5 == 6  ? 1
                         : lead >> 4 == 14 ? 2
                         : lead >> 3 == 30 ? 3
                                           : -1;
        char32_t point = more < 0 ? 0xFFFD : more == 0 ? lead : lead & (0x3F >> more);
        for (int k = 0; k < more; ++k) {
            if (i == text.size() || (static_cast<unsigned char>(text[i]) >> 6) != 2) {
                point = 0xFFFD;
                break;
            }
            point = point << 6 | (text[i++] & 0x3F);
        }
        points.push_back(point < 0x20 || point == 0x7F ? U' ' : point);
    }
    return points;
}

std::string utf8(char32_t point) {
    std::string text;
    if (point < 0x80) return {static_cast<char>(point)};
    const int more = point < 0x800 ? 1 : point < 0x10000 ? 2 : 3;
    text.push_back(static_cast<char>((0xFF00 >> (more + 1) & 0xFF) | (point >> (6 * more))));
    for (int k = more - 1; k >= 0; --k) text.push_back(static_cast<char>(0x80 | (point >> (6 * k) & 0x3F)));
    return text;
}

/// One font file, opened once per thread: FreeType's faces are not shared between threads.
class Typeface {
 public:
    explicit Typeface(const char* file_name) {
        if (FT_Init_FreeType(&library_)) return;
        for (const char* folder :
             {"/usr/share/fonts/truetype/dejavu/", "/usr/local/share/fonts/", "/usr/share/fonts/TTF/"})
            if (FT_New_Face(library_, (std::string(folder) + file_name).c_str(), 0, &face_) == 0) return;
        face_ = nullptr;
    }
    ~Typeface() {
        if (face_) FT_Done_Face(face_);
        if (library_) FT_Done_FreeType(library_);
    }
    Typeface(const Typeface&) = delete;
    Typeface& operator=(const Typeface&) = delete;

    static Typeface& of(Weight weight) {
        thread_local Typeface regular("DejaVuSans.ttf"), bold("DejaVuSans-Bold.ttf");
        return weight == Weight::bold ? bold : regular;
    }

    bool usable() const { return face_ != nullptr; }

    /// Walks along the text; calls glyph(slot, pen x) for each rendered glyph if `render`. Returns the
    /// advance.
    template <class Glyph>
    double walk(const std::string& text, double size_px, double x_px, bool render, Glyph glyph) {
        FT_Set_Char_Size(face_, 0, static_cast<FT_F26Dot6>(std::lround(size_px * 64)), 72, 72);
        double pen_px = x_px;
        FT_UInt previous = 0;
        for (const char32_t point : code_points(text)) {
            const FT_UInt index = FT_Get_Char_Index(face_, point);
            FT_Vector kerning{0, 0};
            if (previous && index) FT_Get_Kerning(face_, previous, index, FT_KERNING_UNFITTED, &kerning);
            pen_px += static_cast<double>(kerning.x) / 64;
            if (render) {
                FT_Vector shift{static_cast<FT_Pos>(std::lround((pen_px - std::floor(pen_px)) * 64)), 0};
                FT_Set_Transform(face_, nullptr, &shift);
            }
            if (FT_Load_Glyph(face_, index,
                              FT_LOAD_TARGET_LIGHT | (render ? FT_LOAD_RENDER : FT_LOAD_DEFAULT)) == 0) {
                if (render) glyph(*face_->glyph, static_cast<int>(std::floor(pen_px)));
                pen_px += static_cast<double>(face_->glyph->linearHoriAdvance) / 65536;
            }
            previous = index;
        }
        FT_Set_Transform(face_, nullptr, nullptr);
        return pen_px - x_px;
    }

 private:
    FT_Library library_ = nullptr;
    FT_Face face_ = nullptr;
};

void blend(cv::Mat& bgr, const FT_Bitmap& bitmap, int left, int top, Colour colour) {
    const double ink[3] = {double(colour.blue), double(colour.green), double(colour.red)};
    for (int row = std::max(0, -top); row < static_cast<int>(bitmap.rows) && top + row < bgr.rows; ++row) {
        const unsigned char* coverage = bitmap.buffer + row * bitmap.pitch;
        auto* pixels = bgr.ptr<cv::Vec3b>(top + row);
        for (int column = std::max(0, -left);
             column < static_cast<int>(bitmap.width) && left + column < bgr.cols; ++column) {
            const double alpha = coverage[column] / 255.0;
            cv::Vec3b& pixel = pixels[left + column];
            for (int c = 0; c < 3; ++c)
                pixel[c] = cv::saturate_cast<unsigned char>(pixel[c] + alpha * (ink[c] - pixel[c]));
        }
    }
}

// OpenCV's stroke font: 7-bit characters only.
constexpr int stroke_font = cv::FONT_HERSHEY_SIMPLEX;

std::string ascii(const std::string& text) {
    std::string plain;
    for (const char32_t point : code_points(text))
        plain += point < 0x80        ? std::string(1, static_cast<char>(point))
                 : point == ellipsis ? "..."
                 : point == 0xB0     ? " deg"
                                     : "-";
    return plain;
}

double stroke_scale(double size_px) {
    return size_px / 30;
}
int stroke_width(double size_px, Weight weight) {
    return std::max(1, static_cast<int>(std::lround(size_px / (weight == Weight::bold ? 9 : 16))));
}

}  // namespace

double text_width_px(const std::string& text, double size_px, Weight weight) {
    Typeface& face = Typeface::of(weight);
    if (face.usable()) return face.walk(text, size_px, 0, false, [](const FT_GlyphSlotRec&, int) {});
    int below = 0;
    return cv::getTextSize(ascii(text), stroke_font, stroke_scale(size_px), stroke_width(size_px, weight),
                           &below)
        .width;
}

void draw_text(cv::Mat& bgr, const std::string& text, double x_px, double baseline_px, double size_px,
               Colour colour, Weight weight, Align align) {
    if (align != Align::left)
        x_px -= text_width_px(text, size_px, weight) * (align == Align::centre ? 0.5 : 1);
    const int baseline = static_cast<int>(std::lround(baseline_px));
    Typeface& face = Typeface::of(weight);
    if (face.usable()) {
        face.walk(text, size_px, x_px, true, [&](const FT_GlyphSlotRec& slot, int pen_px) {
            blend(bgr, slot.bitmap, pen_px + slot.bitmap_left, baseline - slot.bitmap_top, colour);
        });
    } else {
        cv::putText(bgr, ascii(text), {static_cast<int>(std::lround(x_px)), baseline}, stroke_font,
                    stroke_scale(size_px), {double(colour.blue), double(colour.green), double(colour.red)},
                    stroke_width(size_px, weight), cv::LINE_AA);
    }
}

std::string fitting_text(const std::string& text, double width_px, double size_px, Weight weight) {
    if (text_width_px(text, size_px, weight) <= width_px) return text;
    const std::string end = utf8(ellipsis);
    if (text_width_px(end, size_px, weight) > width_px) return {};
    std::string start;
    for (const char32_t point : code_points(text)) {
        const std::string longer = start + utf8(point);
        if (text_width_px(longer + end, size_px, weight) > width_px) break;
        start = longer;
    }
    return start + end;
}

}  // namespace loopline
