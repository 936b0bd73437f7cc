/// A log of NMEA sentences as fixes with stamps: what was said of one moment belongs together, and dates come
/// from the sentences that have one.
#pragma once

#include <array>
#include <istream>
#include <map>
#include <string>
#include <vector>

#include "gnss/nmea_messages.h"

namespace loopline::gnss {

/// What a log says of one moment.
struct NmeaEpoch {
    TimeOfDayNs time = 0;
    std::optional<DayNumber> date;
    std::optional<GgaMessage> gga;
    std::optional<RmcMessage> rmc;
    std::optional<GstMessage> gst;
    std::optional<VtgMessage> vtg;
    std::optional<GsaMessage> gsa;
    std::optional<HdtMessage> hdt;

    /// What of it concerns the antenna's place; `stamp_ns` is the epoch's.
    GnssFix fix(StampNs stamp_ns) const;
};

struct NmeaLog {
    std::vector<NmeaEpoch> epochs;                     ///< in the log's order
    std::size_t sentences = 0;                         ///< that were used
    std::array<std::size_t, nmea_refusals> refused{};  ///< lines, by the reason
    std::map<std::string, std::size_t> not_used;  ///< good sentences that say nothing of a fix, by their type
    std::size_t without_moment = 0;               ///< good sentences from before the first that has a time
};

/// Takes line after line. Sentences with one time are one epoch; those without a time (VTG, GSA, HDT) belong
/// to the epoch that is open.
class NmeaReader {
 public:
    void read(std::string_view line);
    /// All that was read; the reader is empty then.
    NmeaLog take();

 private:
    template <class Message>
    void read_timed(const NmeaSentence& sentence, std::optional<Message> NmeaEpoch::*part);
    template <class Message>
    void read_untimed(const NmeaSentence& sentence, std::optional<Message> NmeaEpoch::*part);
    void read_zda(const NmeaSentence& sentence);
    NmeaEpoch& epoch_at(TimeOfDayNs time);
    bool refuses(NmeaRefusal refusal);

    NmeaLog log_;
    NmeaSentence sentence_;
};

/// A whole stream.
NmeaLog read_nmea(std::istream& stream);

/// Stamps of all epochs, UTC. One without a date has that which brings it nearest to the epoch before it, so
/// that a log goes on over midnight; those before the first date, nearest to the one after. None if no epoch
/// has a date and `date` is none; if it is given, it is that of the first epoch.
std::optional<std::vector<StampNs>> stamps_of(const NmeaLog& log, std::optional<DayNumber> date = {});

}  // namespace loopline::gnss
