#include "output/feature_points_files.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <optional>

#include "evaluate/statistics.h"
#include "output/output_file.h"

namespace loopline {
namespace {

std::string formatted(const char* format, double value) {
    std::array<char, 64> text{};
    std::snprintf(text.data(), text.size(), format, value);
    return text.data();
}

std::string place_text(const Eigen::Vector2d& p_m) {
    return formatted("%.3f", p_m.x()) + ", " + formatted("%.3f", p_m.y());
}

std::string millimetres(double value_m) {
    return formatted("%.0f", 1000 * value_m);
}

/// A column of errors, with gaps.
struct ErrorColumn {
    std::string title;
    std::vector<std::optional<double>> errors_m;

    Statistics statistics() const {
        std::vector<double> values_m;
        for (const auto& error_m : errors_m)
            if (error_m) values_m.push_back(*error_m);
        return statistics_of(values_m);
    }
};

std::vector<ErrorColumn> error_columns(const std::vector<PointEstimate>& points,
                                       const std::vector<PublishedPoint>& published) {
    std::vector<ErrorColumn> columns(2);
    columns[0].title = "odometry, error mm";
    columns[1].title = "corrected, error mm";
    if (!published.empty()) {
        columns.push_back({"published odometry, error mm", {}});
        columns.push_back({"published corrected, error mm", {}});
    }
    for (const PointEstimate& point : points) {
        columns[0].errors_m.push_back(point.odometry_error_m());
        columns[1].errors_m.push_back(point.estimate_error_m());
        if (published.empty()) continue;
        const auto found = std::find_if(published.begin(), published.end(),
                                        [&](const PublishedPoint& p) { return p.number == point.number; });
        const bool is_there = found != published.end();
        columns[2].errors_m.push_back(
            is_there ? std::optional<double>((found->odometry_m - point.true_m).norm()) : std::nullopt);
        columns[3].errors_m.push_back(
            is_there ? std::optional<double>((found->estimate_m - point.true_m).norm()) : std::nullopt);
    }
    return columns;
}

}  // namespace

void write_feature_points_csv(const std::filesystem::path& file, const std::vector<PointEstimate>& points) {
    OutputFile out(file);
    out.text("number,true_x_m,true_y_m,odometry_x_m,odometry_y_m,estimate_x_m,estimate_y_m\n");
    const auto place = [&out](const Eigen::Vector2d& p_m) {
        for (int i = 0; i < 2; ++i) out.text(",").number(std::round(p_m[i] * 1e6) / 1e6);
    };
    for (const PointEstimate& point : points) {
        out.integer(point.number);
        place(point.true_m);
        if (point.odometry_m)
            place(*point.odometry_m);
        else
            out.text(",,");
        place(point.estimate_m);
        out.text("\n");
    }
    out.commit();
}

std::string feature_points_table(const std::vector<PointEstimate>& points,
                                 const std::vector<PublishedPoint>& published) {
    const auto columns = error_columns(points, published);
    std::string head = "| point | true x, y m | odometry x, y m | corrected x, y m |",
                rule = "| ---: | ---: | ---: | ---: |";
    for (const ErrorColumn& column : columns) {
        head += " " + column.title + " |";
        rule += " ---: |";
    }
    std::string table = head + " returns |\n" + rule + " ---: |\n";
    const auto cell = [](const std::optional<double>& error_m) {
        return " " + (error_m ? millimetres(*error_m) : std::string()) + " |";
    };
    for (std::size_t i = 0; i < points.size(); ++i) {
        const PointEstimate& point = points[i];
        table += "| " + std::to_string(point.number) + " | " + place_text(point.true_m) + " | " +
                 (point.odometry_m ? place_text(*point.odometry_m) : std::string()) + " | " +
                 place_text(point.estimate_m) + " |";
        for (const ErrorColumn& column : columns) table += cell(column.errors_m[i]);
        table += " " + std::to_string(point.returns) + " |\n";
    }
    const std::pair<const char*, double Statistics::*> rows[] = {
        {"mean", &Statistics::mean}, {"RMS", &Statistics::rmse}, {"max", &Statistics::max}};
    for (const auto& [name, value] : rows) {
        table += std::string("| ") + name + " | | | |";
        for (const ErrorColumn& column : columns) {
            const Statistics statistics = column.statistics();
            table += cell(statistics.count > 0 ? std::optional<double>(statistics.*value) : std::nullopt);
        }
        table += " |\n";
    }
    return table;
}

}  // namespace loopline
