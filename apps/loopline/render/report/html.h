/// Small pieces of HTML.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace loopline::html {

/// Text for element content and for quoted attributes. Bytes that are not UTF-8, and control characters that
/// HTML forbids, become the replacement character.
std::string escaped(std::string_view text);

/// A relative link to a file below the page: every byte that is not unreserved is percent-encoded, "/" stays.
std::string relative_link(std::string_view path);

std::string base64(std::string_view bytes);

/// `value` with about `digits` significant digits, no exponent where one reads better without, "." whatever
/// the locale.
std::string number(double value, int digits = 4);

/// "12.3 kB", "4.56 MB".
std::string file_size(std::uintmax_t bytes);

}  // namespace loopline::html
