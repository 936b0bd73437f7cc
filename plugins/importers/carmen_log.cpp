#include "importers/carmen_log.h"

#include <charconv>
#include <cmath>
#include <stdexcept>
#include <string_view>

#include "api/parameters.h"

namespace loopline::carmen {
namespace {

constexpr std::size_t most_beams = 100000;  // a damaged count must not ask for all memory
constexpr std::size_t most_skipped_names = 50;

/// Why a line is left out.
struct Damage : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// The words of a line, taken one after the other.
class Words {
 public:
    explicit Words(std::string_view line) : rest_(line) {}

    std::string_view next(const char* what) {
        const std::size_t begin = rest_.find_first_not_of(" \t\r\n");
        if (begin == std::string_view::npos) throw Damage(std::string("ends before its ") + what);
        rest_.remove_prefix(begin);
        const std::string_view word = rest_.substr(0, rest_.find_first_of(" \t\r\n"));
        rest_.remove_prefix(word.size());
        return word;
    }

    bool at_end() const { return rest_.find_first_not_of(" \t\r\n") == std::string_view::npos; }

    double number(const char* what) {
        const double value = any_number(what);
        if (!std::isfinite(value)) throw Damage(std::string("has a ") + what + " that is not finite");
        return value;
    }

    float range_m() {
        const double value = any_number("range");
        return std::isfinite(value) ? static_cast<float>(value) : 0.0F;
    }

    std::size_t count(const char* what) {
        const double value = number(what);
        if (value < 0 || value > static_cast<double>(most_beams) || value != std::floor(value))
            throw Damage(std::string("has no sensible ") + what);
        return static_cast<std::size_t>(value);
    }

    StampNs time(const char* what) {
        const std::string_view word = next(what);
        if (const auto stamp_ns = stamp_from_seconds_text(word)) return *stamp_ns;
        if (const auto seconds = number_from_text(std::string(word)); seconds && std::abs(*seconds) < 9e9)
            return static_cast<StampNs>(std::llround(*seconds * 1e9));
        throw Damage(std::string("has a ") + what + " that is no time in seconds");
    }

    Pose2 pose(const char* what) {
        const double x_m = number(what), y_m = number(what), phi_rad = number(what);
        return {x_m, y_m, wrap_to_pi(phi_rad)};
    }

 private:
    double any_number(const char* what) {
        std::string_view word = next(what);
        if (word.front() == '+') word.remove_prefix(1);
        double value = 0;
        const auto end = std::from_chars(word.data(), word.data() + word.size(), value);
        if (end.ec != std::errc() || end.ptr != word.data() + word.size())
            throw Damage(std::string("has a ") + what + " that is no number");
        return value;
    }

    std::string_view rest_;
};

Times read_times(Words& words) {
    Times times;
    times.ipc_ns = words.time("ipc time");
    words.next("host name");
    times.logger_ns = words.time("logger time");
    if (!words.at_end()) throw Damage("goes on behind its logger time");
    return times;
}

void read_ranges(Words& words, Scan& scan) {
    const std::size_t beams = words.count("number of ranges");
    if (beams == 0) throw Damage("has no ranges");
    scan.ranges_m.reserve(beams);
    for (std::size_t i = 0; i < beams; ++i) scan.ranges_m.push_back(words.range_m());
}

void skip_remissions(Words& words) {
    for (std::size_t i = words.count("number of remissions"); i > 0; --i) words.next("remissions");
}

LaserConfiguration read_configuration(Words& words) {
    LaserConfiguration configuration;
    words.number("laser type");
    configuration.start_angle_rad = words.number("start angle");
    words.number("field of view");
    configuration.resolution_rad = words.number("resolution");
    configuration.max_range_m = words.number("maximum range");
    words.number("accuracy");
    words.number("remission mode");
    if (!(configuration.resolution_rad > 0)) throw Damage("has a resolution that is not above 0");
    return configuration;
}

Record read_scan(Message message, Words& words) {
    Scan scan;
    scan.message = message;
    if (message != Message::flaser) scan.configuration = read_configuration(words);
    read_ranges(words, scan);
    if (message != Message::flaser) skip_remissions(words);
    if (message != Message::rawlaser) {
        scan.T_odom_laser = words.pose("laser pose");
        scan.T_odom_base = words.pose("robot pose");
    }
    if (message == Message::robotlaser)
        for (int i = 0; i < 5; ++i) words.number("speed or safety distance");
    scan.times = read_times(words);
    return scan;
}

Record read_odometry(Words& words) {
    Odometry odometry;
    odometry.T_odom_base = words.pose("pose");
    odometry.speed_mps = words.number("speed");
    odometry.turn_rate_radps = words.number("turn rate");
    words.number("acceleration");
    odometry.times = read_times(words);
    return odometry;
}

void read_line(std::string_view line, Log& log) {
    Words words(line);
    const std::string name(words.next("message name"));
    if (name == "FLASER") {
        log.records.push_back(read_scan(Message::flaser, words));
    } else if (name == "ROBOTLASER1") {
        log.records.push_back(read_scan(Message::robotlaser, words));
    } else if (name == "RAWLASER1") {
        log.records.push_back(read_scan(Message::rawlaser, words));
    } else if (name == "ODOM") {
        log.records.push_back(read_odometry(words));
    } else if (name == "PARAM") {
        const std::string parameter(words.next("name"));
        log.parameters[parameter] = std::string(words.next("value"));
    } else if (log.skipped.count(name) || log.skipped.size() < most_skipped_names) {
        ++log.skipped[name];
    }
}

}  // namespace

const char* name_of(Message message) {
    switch (message) {
        case Message::flaser:
            return "FLASER";
        case Message::robotlaser:
            return "ROBOTLASER1";
        case Message::rawlaser:
            break;
    }
    return "RAWLASER1";
}

void read_log(std::istream& input, const std::string& name, Log& log) {
    std::string line;
    for (std::size_t number = 1; std::getline(input, line); ++number) {
        const std::size_t begin = line.find_first_not_of(" \t\r\n");
        if (begin == std::string::npos || line[begin] == '#') continue;
        try {
            read_line(line, log);
        } catch (const Damage& damage) {
            const std::string_view word =
                std::string_view(line).substr(begin, line.find_first_of(" \t\r\n", begin) - begin);
            log.damaged.push_back(name + ":" + std::to_string(number) + ": this " + std::string(word) +
                                  " line " + damage.what() + "; it is left out");
        }
    }
}

}  // namespace loopline::carmen
