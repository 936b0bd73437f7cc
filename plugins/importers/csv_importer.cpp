#include "importers/csv_importer.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <filesystem>
#include <limits>
#include <set>

#include "config/did_you_mean.h"
#include "importers/csv_gnss.h"
#include "importers/csv_reference.h"
#include "importers/csv_streams.h"

namespace loopline {
IMPLEMENTS_MRPT_OBJECT(CsvImporter, Importer, loopline)

namespace fs = std::filesystem;
using namespace csv;

namespace {

/// The inputs of the command line, by the names that a map gives them.
class Inputs {
 public:
    explicit Inputs(const std::vector<std::string>& paths) : paths_(paths) {}

    /// Empty, and a problem at the key's place, if there is no such file.
    std::string find(ColumnMap& map, const Section& section, const std::string& key, const std::string& name,
                     std::vector<Problem>& problems) {
        std::vector<std::string> there;
        for (const auto& path : paths_) {
            std::error_code none;
            if (fs::is_directory(path, none)) {
                const fs::path file = fs::path(path) / name;
                if (fs::is_regular_file(file, none)) return file.string();
                for (const auto& entry : fs::directory_iterator(path, none))
                    there.push_back(entry.path().filename().string());
            } else {
                there.push_back(fs::path(path).filename().string());
                if (there.back() == name) {
                    used_.insert(path);
                    return path;
                }
            }
        }
        std::sort(there.begin(), there.end());
        problems.emplace_back(
            map.origin(section, key),
            "[" + section.name + "] " + key + " names " + name + ", which is neither an input nor in one" +
                did_you_mean(name, there, there.size() > 12 ? "" : "; there is " + listing(there)),
            exit_input_data);
        return {};
    }

    void tell_unused(RawlogSink& sink) const {
        for (const auto& path : paths_)
            if (!fs::is_directory(path) && used_.count(path) == 0)
                sink.warn("no section of the column map names " + path + ", so it is not read");
    }

 private:
    const std::vector<std::string>& paths_;
    std::set<std::string> used_;
};

/// All tables of a map, open, their columns found.
struct OpenTables {
    std::vector<std::unique_ptr<SensorStream>> streams;
    std::unique_ptr<Reference> reference;
    std::unique_ptr<Rows> utc_rows;
};

OpenTables open_tables(ColumnMap& map, Inputs& inputs) {
    OpenTables tables;
    std::vector<Problem> problems;
    for (const auto& section : map.sections) {
        const std::string path = inputs.find(map, *section, "file", section->file, problems),
                          second = section->acceleration_file.empty()
                                       ? std::string()
                                       : inputs.find(map, *section, "acceleration_file",
                                                     section->acceleration_file, problems);
        if (path.empty() || (second.empty() && !section->acceleration_file.empty())) continue;
        if (section->kind == Kind::reference) {
            if (tables.reference)
                problems.emplace_back(map.origin(*section, "kind"),
                                      "[" + section->name + "] kind is a second reference; remove one");
            tables.reference = std::make_unique<Reference>(map, *section, path, problems);
            continue;
        }
        tables.streams.push_back(make_stream(map, *section, path, second, problems));
        if (problems.empty() && section->name == map.clock.utc_from)
            tables.utc_rows = std::make_unique<Rows>(map, *section, path, false, problems);
    }
    if (!problems.empty()) throw ConfigurationError(problems);
    return tables;
}

Clock clock_of(const ColumnMap& map, Rows* utc_rows, RawlogSink& sink) {
    const auto ns = [](double seconds) { return static_cast<StampNs>(std::llround(seconds * 1e9)); };
    Clock clock{ns(map.clock.add_s)};
    if (!utc_rows) return clock;
    const ClockOffset found = clock_offset(*utc_rows);
    if (found.fixes == 0) throw std::runtime_error("[" + map.clock.utc_from + "] has no fix that tells UTC");
    constexpr double much_s = 0.05;
    if (found.spread_s > much_s)
        sink.warn("the clock of the tables runs at another rate than UTC: " +
                  number_text(std::round(found.spread_s * 1e3) / 1e3) +
                  " s between the halves of the log; stamps other than those of fixes are off by as much");
    clock.offset_ns = found.offset_ns + ns(map.clock.latency_s);
    return clock;
}

/// One stream with its next readings.
struct Head {
    SensorStream* stream;
    std::deque<Reading> next;
    std::size_t written = 0;
    StampNs latest_ns = std::numeric_limits<StampNs>::min();  ///< of those that were not ahead

    void look_ahead(const Clock& clock) {
        constexpr std::size_t readings = 16;
        for (Reading reading; next.size() < readings && stream->next(clock, reading); reading = {})
            next.push_back(std::move(reading));
    }
    /// When the next is due: a few that are stamped far ahead do not hold up those behind them.
    StampNs due_ns() const {
        StampNs due_ns = next.front().known_ns;
        for (const Reading& reading : next)
            if (reading.known_ns >= latest_ns) due_ns = std::min(due_ns, reading.known_ns);
        return due_ns;
    }
};

/// Merged by when they were known; of equals, the section first in the map.
std::vector<Head> write_merged(const OpenTables& tables, const Clock& clock, RawlogSink& sink,
                               StampNs& first_ns, StampNs& last_ns) {
    std::vector<Head> heads;
    for (const auto& stream : tables.streams) {
        heads.push_back({stream.get(), {}});
        heads.back().look_ahead(clock);
    }
    bool any = false;
    while (true) {
        Head* earliest = nullptr;
        for (Head& head : heads)
            if (!head.next.empty() && (!earliest || head.due_ns() < earliest->due_ns())) earliest = &head;
        if (!earliest) return heads;
        const StampNs known_ns = earliest->next.front().known_ns;
        first_ns = any ? std::min(first_ns, known_ns) : known_ns;
        last_ns = any ? std::max(last_ns, known_ns) : known_ns;
        any = true;
        sink.write(*earliest->next.front().observation);
        ++earliest->written;
        earliest->latest_ns = earliest->due_ns();
        earliest->next.pop_front();
        earliest->look_ahead(clock);
    }
}

std::size_t write_reference(Reference& reference, const Clock& clock, RawlogSink& sink) {
    std::size_t poses = 0;
    for (Reference::TruePose pose; reference.next(pose); ++poses)
        sink.true_pose(clock.utc_ns(pose.time_ns), pose.T_ref_base);
    if (poses > 0 && reference.frame()) sink.true_frame(*reference.frame());
    for (const auto& sentence : reference.complaints()) sink.warn(sentence);
    return poses;
}

}  // namespace

ModuleInfo CsvImporter::info() const {
    return {
        "csv",
        "Tables (CSV) of wheels, IMUs, GNSS receivers and references, as a column map says what is in them.",
        {},
        {},
        {"CObservationOdometry", "CObservationIMU", "CObservationGPS"}};
}

ParameterTable CsvImporter::parameters() {
    return ParameterTable("csv", info().sentence)
        .text("columns", columns_,
              "The column map: an .ini file, or the name of one that comes with the program, such as husky.");
}

std::string CsvImporter::check() const {
    if (columns_.empty()) return "columns is missing; give --columns MAP.ini, as in datasets/columns";
    return {};
}

std::vector<ParameterTable> CsvImporter::sections() {
    described_ = std::make_shared<AllKinds>();
    return described_->tables();
}

std::string CsvImporter::import(const std::vector<std::string>& paths, RawlogSink& sink) {
    ColumnMap map = read_column_map(path_of_column_map(columns_));
    Inputs inputs(paths);
    const OpenTables tables = open_tables(map, inputs);
    const Clock clock = clock_of(map, tables.utc_rows.get(), sink);
    StampNs first_ns = 0, last_ns = 0;
    const auto heads = write_merged(tables, clock, sink, first_ns, last_ns);
    std::string summary;
    for (const Head& head : heads) {
        for (const auto& sentence : head.stream->complaints()) sink.warn(sentence);
        if (head.written == 0)
            throw std::runtime_error("no line of " + head.stream->section().file + " gives all that [" +
                                     head.stream->section().name + "] in " + map.path + " asks for");
        summary += std::to_string(head.written) + " of " + head.stream->section().name + ", ";
    }
    if (tables.reference)
        summary += std::to_string(write_reference(*tables.reference, clock, sink)) + " true poses, ";
    inputs.tell_unused(sink);
    return summary + "over " + number_text(std::round(seconds_between(first_ns, last_ns) * 10) / 10) + " s";
}

}  // namespace loopline
