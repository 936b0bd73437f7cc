#include "gnss/nmea_log.h"

#include <utility>

#include "gnss/limits.h"

namespace loopline::gnss {
namespace {

constexpr std::size_t most_unused_types = 100;

FixQuality quality_of_mode(char mode) {
    switch (mode) {
        case 'A':
            return FixQuality::single;
        case 'D':
            return FixQuality::differential;
        case 'R':
            return FixQuality::rtk_fixed;
        case 'F':
            return FixQuality::rtk_float;
        case 'P':
            return FixQuality::pps;
        case 'E':
            return FixQuality::estimated;
        case 'M':
            return FixQuality::manual;
        case 'S':
            return FixQuality::simulator;
        default:
            return FixQuality::invalid;
    }
}

}  // namespace

GnssFix NmeaEpoch::fix(StampNs stamp_ns) const {
    GnssFix fix;
    fix.stamp_ns = stamp_ns;
    if (gga) {
        fix.quality = gga->quality;
        fix.has_position = gga->has_position;
        fix.has_height = gga->has_position && gga->has_altitude;
        fix.geoid_separation_m = gga->geoid_separation_m;
        fix.antenna = {gga->latitude_deg, gga->longitude_deg, gga->altitude_m + gga->geoid_separation_m};
        fix.satellites = gga->satellites;
        fix.hdop = gga->hdop;
    } else if (rmc) {
        fix.quality = rmc->valid ? quality_of_mode(rmc->mode) : FixQuality::invalid;
        fix.has_position = rmc->has_position;
        fix.antenna = {rmc->latitude_deg, rmc->longitude_deg, 0};
    }
    if (gst) fix.sigma_enu_m = gst->sigma_enu_m;
    if (gsa) {
        fix.vdop = gsa->vdop;
        if (!fix.hdop) fix.hdop = gsa->hdop;
    }
    std::optional<double> course_deg;
    if (vtg) {
        fix.speed_mps = vtg->speed_mps;
        course_deg = vtg->course_deg;
    }
    if (rmc && rmc->valid) {
        if (rmc->speed_mps) fix.speed_mps = rmc->speed_mps;
        if (rmc->course_deg) course_deg = rmc->course_deg;
    }
    if (course_deg) fix.course_rad = east_angle_rad(*course_deg);
    if (hdt && hdt->heading_deg) fix.heading_rad = east_angle_rad(*hdt->heading_deg);
    return fix;
}

bool NmeaReader::refuses(NmeaRefusal refusal) {
    if (refusal == NmeaRefusal::none) return false;
    ++log_.refused[static_cast<std::size_t>(refusal)];
    return true;
}

NmeaEpoch& NmeaReader::epoch_at(TimeOfDayNs time) {
    if (log_.epochs.empty() || log_.epochs.back().time != time) {
        log_.epochs.emplace_back();
        log_.epochs.back().time = time;
    }
    return log_.epochs.back();
}

template <class Message>
void NmeaReader::read_timed(const NmeaSentence& sentence, std::optional<Message> NmeaEpoch::*part) {
    Message message;
    if (refuses(read_message(sentence, message))) return;
    ++log_.sentences;
    if (!message.time) {
        ++log_.without_moment;
        return;
    }
    NmeaEpoch& epoch = epoch_at(*message.time);
    if (!(epoch.*part)) epoch.*part = message;
    if constexpr (std::is_same_v<Message, RmcMessage>)
        if (message.date) epoch.date = message.date;
}

template <class Message>
void NmeaReader::read_untimed(const NmeaSentence& sentence, std::optional<Message> NmeaEpoch::*part) {
    Message message;
    if (refuses(read_message(sentence, message))) return;
    ++log_.sentences;
    if (log_.epochs.empty())
        ++log_.without_moment;
    else if (!(log_.epochs.back().*part))
        log_.epochs.back().*part = message;  // the first of several GSA, one for each system
}

void NmeaReader::read_zda(const NmeaSentence& sentence) {
    ZdaMessage zda;
    if (refuses(read_message(sentence, zda))) return;
    ++log_.sentences;
    if (zda.time && zda.date)
        epoch_at(*zda.time).date = zda.date;
    else
        ++log_.without_moment;
}

void NmeaReader::read(std::string_view line) {
    if (line.find_first_not_of(" \t\r\n") == std::string_view::npos) return;
    if (refuses(read_sentence(line, sentence_))) return;
    if (sentence_.is("GGA")) return read_timed(sentence_, &NmeaEpoch::gga);
    if (sentence_.is("RMC")) return read_timed(sentence_, &NmeaEpoch::rmc);
    if (sentence_.is("GST")) return read_timed(sentence_, &NmeaEpoch::gst);
    if (sentence_.is("VTG")) return read_untimed(sentence_, &NmeaEpoch::vtg);
    if (sentence_.is("GSA")) return read_untimed(sentence_, &NmeaEpoch::gsa);
    if (sentence_.is("HDT")) return read_untimed(sentence_, &NmeaEpoch::hdt);
    if (sentence_.is("ZDA")) return read_zda(sentence_);
    const std::string type = (sentence_.talker == "P" ? "P" : "") + std::string(sentence_.type);
    if (log_.not_used.count(type) > 0 || log_.not_used.size() < most_unused_types) ++log_.not_used[type];
}

NmeaLog NmeaReader::take() {
    return std::exchange(log_, {});
}

NmeaLog read_nmea(std::istream& stream) {
    NmeaReader reader;
    for (std::string line; std::getline(stream, line);) reader.read(line);
    return reader.take();
}

std::optional<std::vector<StampNs>> stamps_of(const NmeaLog& log, std::optional<DayNumber> date) {
    const auto& epochs = log.epochs;
    std::vector<StampNs> stamps_ns(epochs.size());
    const auto dated = [&](std::size_t i) { return epochs[i].date || (i == 0 && date); };
    std::size_t first = 0;
    while (first < epochs.size() && !dated(first)) ++first;
    if (first == epochs.size()) return std::nullopt;
    for (std::size_t i = first; i < epochs.size(); ++i)
        stamps_ns[i] = dated(i) ? epochs[i].date.value_or(date.value_or(0)) * day_ns + epochs[i].time
                                : nearest_moment_ns(epochs[i].time, stamps_ns[i - 1]);
    for (std::size_t i = first; i-- > 0;) stamps_ns[i] = nearest_moment_ns(epochs[i].time, stamps_ns[i + 1]);
    return stamps_ns;
}

}  // namespace loopline::gnss
