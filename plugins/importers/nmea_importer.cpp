#include "importers/nmea_importer.h"

#include <charconv>
#include <fstream>
#include <stdexcept>

#include "gnss/gps_observation.h"

namespace loopline {
IMPLEMENTS_MRPT_OBJECT(NmeaImporter, Importer, loopline)

using namespace gnss;

namespace {

/// "2024-05-31"; none if that is no day.
std::optional<DayNumber> day_of(const std::string& text) {
    if (text.size() != 10 || text[4] != '-' || text[7] != '-') return std::nullopt;
    const auto number = [&](std::size_t from, std::size_t length) {
        int value = -1;
        const char* const end = text.data() + from + length;
        return std::from_chars(text.data() + from, end, value).ptr == end ? value : -1;
    };
    return day_number(number(0, 4), number(5, 2), number(8, 2));
}

void report_refusals(const NmeaLog& log, RawlogSink& sink) {
    for (std::size_t i = 1; i < nmea_refusals; ++i)
        if (log.refused[i] > 0)
            sink.warn(std::to_string(log.refused[i]) + (log.refused[i] == 1 ? " line" : " lines") + " with " +
                      name_of(static_cast<NmeaRefusal>(i)) + " left out");
    if (log.without_moment > 0)
        sink.warn(std::to_string(log.without_moment) +
                  " sentences that belong to no time of day are left out");
}

}  // namespace

ModuleInfo NmeaImporter::info() const {
    return {"nmea",
            "Sentences of a GNSS receiver, NMEA 0183 (GGA, RMC, GST, VTG, GSA, HDT, ZDA): CObservationGPS, "
            "stamped with the receiver's time.",
            {},
            {},
            {"CObservationGPS"}};
}

ParameterTable NmeaImporter::parameters() {
    return ParameterTable("nmea", info().sentence)
        .text("label", label_, "Label of the observations.")
        .text(
            "date", date_,
            "Day of the first fix (UTC), as 2024-05-31, for logs without RMC and ZDA; empty: the log's own.")
        .real("antenna_x_m", p_base_antenna_m_.x(), {-1000, 1000},
              "Where the antenna is on the vehicle, ahead of its origin.")
        .real("antenna_y_m", p_base_antenna_m_.y(), {-1000, 1000}, "The same, to the left.")
        .real("antenna_z_m", p_base_antenna_m_.z(), {-1000, 1000}, "The same, above.");
}

std::string NmeaImporter::check() const {
    if (!date_.empty() && !day_of(date_)) return "date is no day such as 2024-05-31";
    return {};
}

std::string NmeaImporter::import(const std::vector<std::string>& inputs, RawlogSink& sink) {
    NmeaReader reader;
    for (const auto& input : inputs) {
        std::ifstream stream(input, std::ios::binary);
        if (!stream || stream.peek() == std::ifstream::traits_type::eof())
            throw std::runtime_error(input + " can't be read, or is empty; give a log of NMEA sentences");
        for (std::string line; std::getline(stream, line);) reader.read(line);
    }
    const NmeaLog log = reader.take();
    report_refusals(log, sink);
    if (log.epochs.empty())
        throw std::runtime_error("there is no GGA, RMC or GST sentence with a time in the input");
    const auto stamps_ns = stamps_of(log, date_.empty() ? std::nullopt : day_of(date_));
    if (!stamps_ns)
        throw std::runtime_error(
            "no RMC or ZDA sentence says the date; give that of the first fix with --date");

    std::size_t written = 0, usable = 0, backwards = 0;
    StampNs first_ns = 0, last_ns = 0;
    for (std::size_t i = 0; i < log.epochs.size(); ++i) {
        const NmeaEpoch& epoch = log.epochs[i];
        if (!epoch.gga && !epoch.rmc) continue;
        GnssFix fix = epoch.fix((*stamps_ns)[i]);
        fix.p_base_antenna_m = p_base_antenna_m_;
        sink.write(*gps_observation(fix, label_));
        if (written++ == 0)
            first_ns = fix.stamp_ns;
        else
            backwards += fix.stamp_ns < last_ns;
        last_ns = fix.stamp_ns;
        usable += fix.is_usable();
    }
    std::string sentence = std::to_string(written) + " fixes, " + std::to_string(usable) +
                           " of them with a measured position, over " +
                           number_text(std::round(seconds_between(first_ns, last_ns) * 10) / 10) + " s";
    if (backwards > 0)
        sentence += "; the stamps go back " + std::to_string(backwards) + " times, the file's order is kept";
    for (const auto& [type, count] : log.not_used)
        sentence += "; " + std::to_string(count) + " " + type + " sentences skipped";
    return sentence;
}

}  // namespace loopline
