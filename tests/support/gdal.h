/// GDAL's programs as independent readers of files on the Earth; tests that need them are skipped, visibly,
/// where they are missing.
#pragma once

#include <gtest/gtest.h>

#include <sstream>
#include <string>
#include <vector>

#include "support/run_program.h"

#define SKIP_WITHOUT_GDAL() \
    if (!loopline::test::has_gdal()) GTEST_SKIP() << "GDAL's programs (gdal-bin) are not installed"

namespace loopline::test {

inline bool has_gdal() {
    static const bool has = run_program({"gdalsrsinfo", "--version"}).exit_code == 0;
    return has;
}

/// What the program says on its standard output.
inline std::string said_by(const std::vector<std::string>& words) {
    const ProgramResult result = run_program(words);
    EXPECT_EQ(result.exit_code, 0) << words.front() << ": " << result.err;
    return result.out;
}

/// All positions of the features that SQL's condition selects, in their order, as rows of numbers: longitude,
/// latitude and, if there is one, height.
inline std::vector<std::vector<double>> positions_by_gdal(const std::string& file,
                                                          const std::string& condition) {
    const std::string csv = said_by(
        {"ogr2ogr", "-f", "CSV", "/vsistdout/", file, "-lco", "GEOMETRY=AS_WKT", "-where", condition});
    std::vector<std::vector<double>> positions;
    std::istringstream lines(csv);
    std::string line;
    std::getline(lines, line);  // names of columns
    while (std::getline(lines, line)) {
        const auto begin = line.find('('), end = line.rfind(')');
        if (begin == std::string::npos) continue;
        std::string text = line.substr(begin, end - begin);
        for (char& c : text)
            if (c == '(' || c == ')') c = ' ';
        std::istringstream vertices(text);
        for (std::string vertex; std::getline(vertices, vertex, ',');) {
            std::istringstream numbers(vertex);
            std::vector<double> position;
            for (double number; numbers >> number;) position.push_back(number);
            positions.push_back(position);
        }
    }
    return positions;
}

/// Numbers in a text, one after the other.
inline std::vector<double> numbers_in(const std::string& text) {
    std::istringstream in(text);
    std::vector<double> numbers;
    for (double number; in >> number;) numbers.push_back(number);
    return numbers;
}

}  // namespace loopline::test
