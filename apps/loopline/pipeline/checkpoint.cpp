#include "pipeline/checkpoint.h"

#include <link.h>

#include <algorithm>
#include <cstring>
#include <sstream>

#include "api/state_archive.h"
#include "commands/command.h"
#include "pipeline/file_hash.h"

namespace loopline {

template <class Archive>
void fields(Archive& archive, LogIdentity& log) {
    archive(log.bytes, log.sha256);
}

template <class Archive>
void fields(Archive& archive, KeptState& state) {
    archive(state.loop, state.items, state.bytes);
}

template <class Archive>
void fields(Archive& archive, CheckpointHead& head) {
    archive(head.program, head.effective_ini, head.logs, head.items, head.wall_s, head.cpu_s, head.loop,
            head.loop_ns, head.kept);
}

template <class Archive>
void fields(Archive& archive, RecorderState& state) {
    archive(state.file_bytes, state.file_checksum, state.open_block, state.recorded, state.unseen);
}

template <class Archive>
void fields(Archive& archive, ModuleTiming& timing) {
    archive(timing.calls, timing.total_ms, timing.worst_ms, timing.finish_ms);
}

namespace {

namespace fs = std::filesystem;
const char* const start_over = "run without --resume to start from the beginning";

/// The "GNU build-id" of a loaded library, as it stands in its notes.
int add_build_id(dl_phdr_info* library, std::size_t, void* text) {
    const std::string path = library->dlpi_name;
    const bool ours = path.empty() || path.find("libloopline") != std::string::npos;  // empty: the program
    if (!ours && path.find("libmrpt") == std::string::npos) return 0;
    for (int i = 0; i < library->dlpi_phnum; ++i) {
        const auto& part = library->dlpi_phdr[i];
        if (part.p_type != PT_NOTE) continue;
        const char* note = reinterpret_cast<const char*>(library->dlpi_addr + part.p_vaddr);
        const char* const end = note + part.p_memsz;
        while (note + sizeof(ElfW(Nhdr)) <= end) {
            ElfW(Nhdr) header;
            std::memcpy(&header, note, sizeof(header));
            const auto padded = [](std::size_t size) { return (size + 3) / 4 * 4; };
            const char* const name = note + sizeof(header);
            const char* const content = name + padded(header.n_namesz);
            if (content + header.n_descsz > end) break;
            if (header.n_type == NT_GNU_BUILD_ID && header.n_namesz == 4 && std::memcmp(name, "GNU", 4) == 0)
                static_cast<std::string*>(text)->append(content, header.n_descsz);
            note = content + padded(header.n_descsz);
        }
    }
    return 0;
}

}  // namespace

std::string first_difference(const std::string& before, const std::string& now) {
    std::istringstream a(before), b(now);
    std::string section, line_a, line_b;
    while (std::getline(a, line_a)) {
        if (!std::getline(b, line_b)) break;
        if (line_a != line_b) {
            const auto equals = line_b.find('=');
            const bool same_key =
                equals != std::string::npos && line_a.compare(0, equals + 1, line_b, 0, equals + 1) == 0;
            return section + " " + line_a + ", and now " +
                   (same_key ? line_b.substr(std::min(equals + 2, line_b.size())) : line_b);
        }
        if (!line_a.empty() && line_a[0] == '[') section = line_a;
    }
    return "a key that the other has not";
}

fs::path checkpoint_in(const fs::path& folder) {
    return folder / "checkpoint.bin";
}

std::vector<std::string> input_paths(const Experiment& experiment) {
    std::vector<std::string> paths = experiment.run.rawlogs;
    for (const auto& module : experiment.modules)
        for (auto& file : module->input_files()) paths.push_back(std::move(file));
    return paths;
}

std::vector<LogIdentity> identities_of(const std::vector<std::string>& paths) {
    std::vector<LogIdentity> logs;
    for (const auto& path : paths) {
        std::error_code gone;  // then its hash is empty too
        logs.push_back({fs::file_size(path, gone), sha256_of_file(path)});
    }
    return logs;
}

std::string build_of_this_program() {
    std::string text = LOOPLINE_VERSION " " LOOPLINE_API_VERSION " ";
    dl_iterate_phdr(add_build_id, &text);
    return text;
}

std::vector<std::string> modules_without_state(const Experiment& experiment) {
    std::vector<std::string> names;
    for (const auto& module : experiment.modules)
        if (!module->can_resume()) names.push_back(module->info().name);
    return names;
}

namespace {

using SinkArchive = mrpt::serialization::CArchiveStreamBase<CheckpointSink>;

/// For a state that outlives the run, and the files beside it.
class WholeArchive : public SinkArchive, public HoldsEverything {
 public:
    using SinkArchive::SinkArchive;
};

void write_state_of_run(CheckpointSink& sink, mrpt::serialization::CArchive& archive, CheckpointHead head,
                        const ModuleChain& chain, RecorderState recorded, CheckpointSink::Safety safety) {
    StateWriter writer(archive);
    std::vector<ModuleTiming> timings = chain.timings();
    writer(head, recorded, timings);
    for (const auto& module : chain.modules()) {
        module->save_state(archive);
        writer.form("end of " + module->info().name, 0);
    }
    sink.commit(safety);
}

}  // namespace

void write_checkpoint(const fs::path& file, const CheckpointHead& head, const ModuleChain& chain,
                      Recorder& recorder) {
    CheckpointSink sink(file);
    SinkArchive archive(sink);
    write_state_of_run(sink, archive, head, chain, recorder.state(), CheckpointSink::Safety::disk);
}

void write_kept_state(const fs::path& file, const CheckpointHead& head, const ModuleChain& chain,
                      Recorder& recorder) {
    CheckpointSink sink(file);
    WholeArchive archive(sink);
    write_state_of_run(sink, archive, head, chain, recorder.state(), CheckpointSink::Safety::file);
}

void write_beginning(const fs::path& file, const CheckpointHead& head) {
    CheckpointSink sink(file);
    mrpt::serialization::CArchiveStreamBase<CheckpointSink> archive(sink);
    StateWriter writer(archive);
    CheckpointHead written = head;
    writer(written);
    sink.commit(CheckpointSink::Safety::file);
}

void remove_checkpoint(const fs::path& folder) {
    std::error_code ignored;  // most runs make none
    fs::remove(checkpoint_in(folder), ignored);
}

Checkpoint::Checkpoint(const fs::path& folder, const Experiment& experiment) : file_(checkpoint_in(folder)) {
    std::error_code ignored;
    if (!fs::exists(file_, ignored)) {
        const auto names = modules_without_state(experiment);
        refuse("there is no checkpoint to resume from" +
               (names.empty() ? "" : " (module " + names.front() + " can't make any)"));
    }
    try {
        read();
    } catch (const std::exception& e) {
        refuse(std::string("this checkpoint can't be used: ") + e.what());
    }
    check(experiment);
}

std::shared_ptr<const Checkpoint> Checkpoint::kept(const fs::path& file,
                                                   const std::function<bool(const CheckpointHead&)>& serves) {
    std::shared_ptr<Checkpoint> checkpoint(new Checkpoint(file));
    try {
        checkpoint->read();
    } catch (const std::exception&) {
        return nullptr;
    }
    const CheckpointHead& head = checkpoint->head_;
    return head.program == build_of_this_program() && serves(head) ? checkpoint : nullptr;
}

void Checkpoint::read() {
    bytes_.emplace(file_);
    mrpt::serialization::CArchiveStreamBase<CheckpointBytes> archive(*bytes_);
    StateReader reader(archive);
    reader(head_);
}

void Checkpoint::check(const Experiment& experiment) const {
    if (head_.program != build_of_this_program())
        refuse("this checkpoint was made by another build of the program");
    if (head_.effective_ini != experiment.effective_ini)
        refuse("this checkpoint was made with another configuration (" +
               first_difference(head_.effective_ini, experiment.effective_ini) + ")");
    const auto paths = input_paths(experiment);
    const auto logs = identities_of(paths);
    for (std::size_t i = 0; i < logs.size(); ++i)
        if (i >= head_.logs.size() || logs[i].bytes != head_.logs[i].bytes ||
            logs[i].sha256 != head_.logs[i].sha256)
            refuse("this checkpoint was made with another " +
                   std::string(i < experiment.run.rawlogs.size() ? "log" : "file") + " than what " +
                   paths[i] + " holds now");
}

void Checkpoint::restore(ModuleChain& chain, Recorder& recorder) const {
    if (head_.items == 0) return;
    CheckpointBytes bytes = *bytes_;
    mrpt::serialization::CArchiveStreamBase<CheckpointBytes> archive(bytes);
    StateReader reader(archive);
    try {
        RecorderState recorded;
        std::vector<ModuleTiming> timings;
        reader(recorded, timings);
        for (const auto& module : chain.modules()) {
            module->load_state(archive);
            reader.form("end of " + module->info().name, 0);
        }
        chain.set_timings(timings);
        recorder.restore(recorded);
    } catch (const CommandError&) {
        throw;
    } catch (const std::exception& e) {
        refuse(std::string("this checkpoint can't be used: ") + e.what());
    }
}

void Checkpoint::refuse(const std::string& clause) const {
    throw CommandError(exit_configuration,
                       file_.string() + ": " + clause + "; " +
                           (head_.loop > 0 ? "remove it to go on from an earlier one" : start_over));
}

}  // namespace loopline
