#include "output/covariance_csv.h"

#include <array>
#include <string>

#include "output/output_file.h"

namespace loopline {
namespace {

std::string covariance_header() {
    const std::array<const char*, 6> names = {"x", "y", "z", "roll", "pitch", "yaw"};
    std::string text = "stamp_s";
    for (std::size_t row = 0; row < 6; ++row)
        for (std::size_t column = 0; column < 6; ++column) {
            const int angles = (row >= 3) + (column >= 3);
            const char* unit = angles == 0 ? "m2" : angles == 1 ? "m_rad" : "rad2";
            text += std::string(",cov_") + names[row] + "_" + names[column] + "_" + unit;
        }
    return text + "\n";
}

}  // namespace

std::size_t write_covariance_csv(const std::filesystem::path& file, const Trajectory& trajectory) {
    OutputFile out(file);
    out.text(covariance_header());
    std::size_t left_out = 0;
    for (const auto& entry : trajectory.entries()) {
        if (!entry.covariance.is_finite()) {
            ++left_out;
            continue;
        }
        out.seconds(entry.stamp_ns);
        for (int row = 0; row < 6; ++row)
            for (int column = 0; column < 6; ++column)
                out.character(',').number(entry.covariance(row, column));
        out.character('\n');
    }
    out.commit();
    return left_out;
}

}  // namespace loopline
