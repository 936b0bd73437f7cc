#include "output/manifest_json.h"

#include <mrpt/system/os.h>

#include <Eigen/Core>
#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "output/output_file.h"
#include "output/run_directory.h"

namespace loopline {
namespace {

using nlohmann::ordered_json;

void save(const std::filesystem::path& folder, const ordered_json& manifest) {
    const auto replace_bad_utf8 = ordered_json::error_handler_t::replace;
    write_whole_file(folder / "manifest.json", manifest.dump(2, ' ', false, replace_bad_utf8) + "\n");
}

ordered_json load(const std::filesystem::path& folder) {
    std::ifstream in(folder / "manifest.json");
    constexpr bool with_exceptions = false;
    return ordered_json::parse(in, nullptr, with_exceptions);
}

ordered_json inputs_of(const RunRecord& record) {
    ordered_json inputs = ordered_json::array();
    for (const auto& input : record.inputs) {
        ordered_json entry;
        entry["path"] = input.path;
        entry["bytes"] = input.bytes;
        if (!input.sha256.empty()) entry["sha256"] = input.sha256;
        if (input.is_log) entry["objects_read"] = input.objects;
        if (!input.damage.empty()) entry["damage"] = input.damage;
        inputs.push_back(entry);
    }
    return inputs;
}

ordered_json versions() {
    ordered_json json;
    json["loopline"] = LOOPLINE_VERSION;
    const std::string mrpt = mrpt::system::MRPT_getVersion();  // "MRPT 2.5.8"
    json["mrpt"] = mrpt.substr(mrpt.find(' ') + 1);
    json["eigen"] = std::to_string(EIGEN_WORLD_VERSION) + "." + std::to_string(EIGEN_MAJOR_VERSION) + "." +
                    std::to_string(EIGEN_MINOR_VERSION);
#ifdef __clang__
    json["compiler"] = __VERSION__;
#else
    json["compiler"] = std::string("GCC ") + __VERSION__;
#endif
    return json;
}

}  // namespace

void write_manifest(const std::filesystem::path& folder, const RunRecord& record,
                    const std::vector<std::string>& writer_warnings, const std::vector<std::string>& files) {
    ordered_json manifest;
    manifest["program"] = "loopline";
    manifest["versions"] = versions();
    manifest["config"] = record.config_path;
    manifest["seed"] = record.seed;
    manifest["inputs"] = inputs_of(record);
    manifest["status"] = record.status;
    manifest["exit_code"] = record.exit_code;
    if (record.results.refused) manifest["refused"] = *record.results.refused;
    manifest["warnings"] = record.warnings;
    for (const auto& warning : writer_warnings) manifest["warnings"].push_back(warning);
    manifest["files"] = files;
    save(folder, manifest);
}

std::vector<std::string> files_in_manifest(const std::filesystem::path& folder) {
    const ordered_json manifest = load(folder);
    std::vector<std::string> files;
    if (!manifest.is_object() || !manifest.contains("files") || !manifest["files"].is_array()) return files;
    for (const auto& file : manifest["files"])
        if (file.is_string()) files.push_back(file.get<std::string>());
    return files;
}

void add_to_manifest(const std::filesystem::path& folder, const std::vector<std::string>& files) {
    ordered_json manifest = load(folder);
    if (!manifest.is_object()) return;
    auto known = files_in_manifest(folder);
    for (const auto& file : files)
        if (std::find(known.begin(), known.end(), file) == known.end()) known.push_back(file);
    manifest["files"] = known;
    save(folder, manifest);
}

}  // namespace loopline
