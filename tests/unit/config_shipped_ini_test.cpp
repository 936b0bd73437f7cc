/// Every experiment file of the source tree is right, and its effective configuration reads back to itself.
#include <gtest/gtest.h>

#include <algorithm>

#include "config/experiment.h"
#include "support/built_files.h"
#include "support/run_program.h"

using namespace loopline;

TEST(ShippedIni, every_one_is_right_and_reads_back) {
    namespace fs = std::filesystem;
    std::vector<fs::path> files;
    for (const char* folder : {"real", "sim"}) {
        std::error_code none;
        for (const auto& entry :
             fs::directory_iterator(fs::path(test::source_folder()) / "ini" / folder, none))
            if (entry.path().extension() == ".ini") files.push_back(entry.path());
    }
    std::sort(files.begin(), files.end());
    if (files.empty()) GTEST_SKIP() << "no experiment file in ini/real or ini/sim";
    const test::TemporaryFolder folder;
    // Whether the logs are on this machine is another question.
    const std::vector<std::string> no_data{"evaluation.truth=", "evaluation.relations="};
    // Nor are finished maps.
    const std::string map =
        folder.write("room.yaml", "image: room.pgm\nresolution: 0.1\norigin: [0, 0, 0]\n");
    folder.write("room.pgm", std::string("P5\n2 1\n255\n\0\xfe", 13));
    std::string points;
    for (int i = 0; i < 2000; ++i) points += std::to_string(i % 50) + " " + std::to_string(i / 50) + " 0\n";
    const std::string cloud = folder.write("cloud.ply",
                                           "ply\nformat ascii 1.0\nelement vertex 2000\nproperty float "
                                           "x\nproperty float y\nproperty float z\nend_header\n" +
                                               points);
    folder.write("georeference.txt",
                 "latitude_deg = 49\nlongitude_deg = 8.4\nheight_m = 200\nheading_deg = 0\n");
    for (const auto& file : files) {
        SCOPED_TRACE(file.string());
        auto overrides = no_data;
        if (test::file_text(file).find("[grid_localisation]") != std::string::npos)
            overrides.push_back("grid_localisation.map=" + map);
        if (test::file_text(file).find("[cloud_localisation]") != std::string::npos)
            overrides.push_back("cloud_localisation.map=" + cloud);
        const auto first = load_experiment(file.string(), overrides, {"/dev/null"});
        const auto again = load_experiment(folder.write("config.ini", first.effective_ini), {}, {});
        EXPECT_EQ(first.effective_ini, again.effective_ini);
    }
}
