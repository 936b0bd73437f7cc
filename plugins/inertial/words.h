/// Numbers in sentences.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdio>
#include <string>

namespace loopline::inertial {

/// With so many significant digits: "0.0912", "57.3".
inline std::string digits(double value, int significant = 3) {
    std::array<char, 48> text{};
    std::snprintf(text.data(), text.size(), "%.*g", significant, value);
    return text.data();
}
/// With so many decimals: "0.091"; zero has no sign.
inline std::string decimals(double value, int places) {
    std::array<char, 64> text{};
    std::snprintf(text.data(), text.size(), "%.*f", places, value);
    const std::string number = text.data();
    return number.find_first_not_of("-0.") == std::string::npos && number[0] == '-' ? number.substr(1)
                                                                                    : number;
}
inline std::string decimals(const Eigen::Vector3d& v, int places) {
    return "(" + decimals(v.x(), places) + ", " + decimals(v.y(), places) + ", " + decimals(v.z(), places) +
           ")";
}
/// "+y", or the direction's numbers if it lies between the axes.
inline std::string axis_name(const Eigen::Vector3d& direction) {
    Eigen::Index axis = 0;
    const Eigen::Vector3d unit = direction.normalized();
    if (unit.cwiseAbs().maxCoeff(&axis) < 0.9) return decimals(unit, 2);
    return std::string(unit(axis) < 0 ? "-" : "+") + "xyz"[axis];
}

}  // namespace loopline::inertial
