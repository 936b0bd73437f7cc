/// Cells of the report's tables.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace loopline {

/// 0 if there is no such number.
inline double number_at(const nlohmann::ordered_json& object, const char* key) {
    const auto found = object.find(key);
    return found != object.end() && found->is_number() ? found->get<double>() : 0;
}

/// `html` in a cell.
inline std::string cell(const std::string& html, const char* css_class = "") {
    return std::string("<td") + (*css_class ? std::string(" class=\"") + css_class + "\"" : "") + ">" + html +
           "</td>";
}

}  // namespace loopline
