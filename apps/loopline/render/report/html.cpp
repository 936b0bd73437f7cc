/// Escaping after the HTML standard, base64 after RFC 4648, links after RFC 3986.
#include "render/report/html.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace loopline::html {
namespace {

/// Length of the well-formed UTF-8 sequence at `i`, 0 if there is none.
std::size_t sequence_length(std::string_view text, std::size_t i) {
    const auto byte = [&](std::size_t k) { return static_cast<unsigned char>(text[k]); };
    const unsigned char lead = byte(i);
    const std::size_t length = lead < 0x80       ? 1
                               : lead >> 5 == 6  ? 2
                               : lead >> 4 == 14 ? 3
                               : lead >> 3 == 30 ? 4
                                                 : 0;
    if (length == 0 || i + length > text.size()) return 0;
    char32_t point = length == 1 ? lead : lead & (0x7F >> length);
    for (std::size_t k = 1; k < length; ++k) {
        if (byte(i + k) >> 6 != 2) return 0;
        point = point << 6 | (byte(i + k) & 0x3F);
    }
    const char32_t smallest[] = {0, 0, 0x80, 0x800, 0x10000};
    const bool is_surrogate = point >= 0xD800 && point < 0xE000;
    return point < smallest[length] || point > 0x10FFFF || is_surrogate ? 0 : length;
}

}  // namespace

std::string escaped(std::string_view text) {
    std::string out;
    out.reserve(text.size() + text.size() / 8);
    for (std::size_t i = 0; i < text.size();) {
        const std::size_t length = sequence_length(text, i);
        const unsigned char c = static_cast<unsigned char>(text[i]);
        const bool is_control = (c < 0x20 && c != '\n' && c != '\t' && c != '\r') || c == 0x7F;
        if (length == 0 || is_control) {
            out += "\uFFFD";
            ++i;
            continue;
        }
        switch (c) {
            case '&':
                out += "&amp;";
                break;
            case '<':
                out += "&lt;";
                break;
            case '>':
                out += "&gt;";
                break;
            case '"':
                out += "&quot;";
                break;
            case '\'':
                out += "&#39;";
                break;
            default:
                out.append(text.substr(i, length));
        }
        i += length;
    }
    return out;
}

std::string relative_link(std::string_view path) {
    static const char hex[] = "0123456789ABCDEF";
    // "./" keeps a name with a colon from being read as a scheme.
    std::string out = "./";
    for (const char c : path) {
        const auto u = static_cast<unsigned char>(c);
        const bool is_plain = (u >= '0' && u <= '9') || (u >= 'A' && u <= 'Z') || (u >= 'a' && u <= 'z') ||
                              c == '-' || c == '.' || c == '_' || c == '~' || c == '/';
        if (is_plain)
            out += c;
        else
            out += {'%', hex[u >> 4], hex[u & 15]};
    }
    return out;
}

std::string base64(std::string_view bytes) {
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string out;
    out.reserve((bytes.size() + 2) / 3 * 4);
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        unsigned group = 0;
        for (std::size_t k = 0; k < 3; ++k)
            group = group << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0);
        for (std::size_t k = 0; k < 4; ++k)
            out += i + k <= bytes.size() ? digits[group >> (18 - 6 * k) & 63] : '=';
    }
    return out;
}

std::string number(double value, int digits) {
    if (!std::isfinite(value)) return "not finite";
    char text[64];
    const double size = std::abs(value);
    if (value != 0 && (size < 1e-4 || size >= 1e9)) {
        std::snprintf(text, sizeof text, "%.*g", digits, value);
    } else {
        const int before = size < 1 ? 1 : static_cast<int>(std::floor(std::log10(size))) + 1;
        const int leading_zeros =
            size > 0 && size < 1 ? static_cast<int>(-std::floor(std::log10(size))) - 1 : 0;
        const int decimals = value == std::floor(value)
                                 ? 0
                                 : std::max(0, digits - before + (size < 1 ? leading_zeros + 1 : 0));
        std::snprintf(text, sizeof text, "%.*f", std::min(decimals, 9), value);
    }
    for (char& c : text)
        if (c == ',') c = '.';
    return text;
}

std::string file_size(std::uintmax_t bytes) {
    if (bytes < 1000) return std::to_string(bytes) + " B";
    const double value = static_cast<double>(bytes);
    if (value < 1e6) return number(value / 1e3, 3) + " kB";
    return value < 1e9 ? number(value / 1e6, 3) + " MB" : number(value / 1e9, 3) + " GB";
}

}  // namespace loopline::html
