/// report.html: one page that needs nothing beside it, and no network.
#include "output/output_file.h"
#include "render/render.h"
#include "render/report/html.h"
#include "render/report/report_style.h"
#include "render/report/sections.h"

namespace loopline {
namespace {

std::string footer_section(const RunFiles& run) {
    std::string text = "Made by Loopline " LOOPLINE_VERSION;
    const auto versions = run.manifest.find("versions");
    if (versions != run.manifest.end() && versions->is_object())
        for (const auto& [name, version] : versions->items())
            if (name != "loopline" && version.is_string())
                text += " \u00b7 " + name + " " + version.get<std::string>();
    return "<footer>" + html::escaped(text) + "</footer>\n";
}

}  // namespace

void write_report(const std::filesystem::path& run_directory) {
    const RunFiles run = read_run_files(run_directory);
    std::string page =
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" "
        "content=\"width=device-width, initial-scale=1\">\n<title>" +
        html::escaped(run_name(run)) + " \u00b7 Loopline</title>\n<style>" + report_style +
        "</style>\n</head>\n<body>\n<main>\n";
    page += header_section(run) + alerts_section(run) + figures_section(run) + feature_points_section(run) +
            pictures_section(run) + loops_section(run) + plots_section(run);
    page += modules_section(run) + inputs_section(run) + config_section(run) + files_section(run) +
            footer_section(run);
    page += "</main>\n</body>\n</html>\n";
    write_whole_file(run_directory / "report.html", page);
}

}  // namespace loopline
