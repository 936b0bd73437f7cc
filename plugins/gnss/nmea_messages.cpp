#include "gnss/nmea_messages.h"

#include <algorithm>
#include <string>

#include "api/parameters.h"
#include "gnss/limits.h"

namespace loopline::gnss {
namespace {

/// Leaves read_message(), which turns it into its refusal.
struct Refused {
    NmeaRefusal why;
};

/// The fields of one sentence, by number.
class Fields {
 public:
    explicit Fields(const NmeaSentence& sentence) : sentence_(sentence) {}

    void need(std::size_t count) const {
        if (sentence_.fields.size() < count) throw Refused{NmeaRefusal::missing_field};
    }
    std::string_view text(std::size_t index) const { return sentence_.field(index); }
    char letter(std::size_t index, char otherwise) const {
        return text(index).size() == 1 ? text(index).front() : otherwise;
    }

    std::optional<double> number(std::size_t index, double least, double most) const {
        if (text(index).empty()) return std::nullopt;
        const auto value = number_from_text(std::string(text(index)));
        if (!value || *value < least || *value > most) throw Refused{NmeaRefusal::impossible_value};
        return value;
    }
    int count(std::size_t index, int most) const {
        const double value = number(index, 0, most).value_or(0);
        if (value != std::floor(value)) throw Refused{NmeaRefusal::impossible_value};
        return static_cast<int>(value);
    }
    std::optional<double> degrees(std::size_t index) const { return number(index, -360, 360); }

    /// hhmmss with any number of decimals.
    std::optional<TimeOfDayNs> time(std::size_t index) const {
        const std::string_view digits = text(index);
        if (digits.empty()) return std::nullopt;
        if (digits.size() < 6 || !all_digits(digits.substr(0, 6)))
            throw Refused{NmeaRefusal::impossible_value};
        const int hour = two_digits(digits, 0), minute = two_digits(digits, 2);
        const auto second_ns = stamp_from_seconds_text(digits.substr(4));
        if (hour > 23 || minute > 59 || !second_ns || *second_ns >= 61'000'000'000)
            throw Refused{NmeaRefusal::impossible_value};
        return (hour * 60 + minute) * 60'000'000'000 + *second_ns;
    }

    /// ddmm.mm and a letter; `positive` north or east.
    std::optional<double> angle_deg(std::size_t index, double most_deg, char positive, char negative) const {
        if (text(index).empty() && text(index + 1).empty()) return std::nullopt;
        const auto number_read = number(index, 0, most_deg * 100);
        const char side = letter(index + 1, '?');
        if (!number_read || (side != positive && side != negative))
            throw Refused{NmeaRefusal::impossible_value};
        const double whole = std::floor(*number_read / 100), minutes = *number_read - 100 * whole;
        const double degrees = whole + minutes / 60;
        if (minutes >= 60 || degrees > most_deg) throw Refused{NmeaRefusal::impossible_value};
        return side == positive ? degrees : -degrees;
    }

    static bool all_digits(std::string_view text) {
        return std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
    }
    static int two_digits(std::string_view text, std::size_t at) {
        return 10 * (text[at] - '0') + (text[at + 1] - '0');
    }

 private:
    const NmeaSentence& sentence_;
};

/// Whether both coordinates are there.
bool read_position(const Fields& fields, std::size_t first, double& latitude_deg, double& longitude_deg) {
    const auto latitude = fields.angle_deg(first, 90, 'N', 'S');
    const auto longitude = fields.angle_deg(first + 2, 180, 'E', 'W');
    latitude_deg = latitude.value_or(0);
    longitude_deg = longitude.value_or(0);
    return latitude && longitude;
}

template <class Read>
NmeaRefusal refusal_of(const Read& read) {
    try {
        read();
        return NmeaRefusal::none;
    } catch (const Refused& refused) {
        return refused.why;
    }
}

std::optional<double> knots(const Fields& fields, std::size_t index) {
    const auto speed = fields.number(index, 0, most_speed_mps / mps_per_knot);
    return speed ? std::optional<double>(*speed * mps_per_knot) : std::nullopt;
}

}  // namespace

std::optional<DayNumber> day_number(int year, int month, int day) {
    const bool leap = (year % 4 == 0 && year % 100 != 0) || year % 400 == 0;
    const int days_of_month[] = {31, leap ? 29 : 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31};
    if (year < 1970 || year > 2200 || month < 1 || month > 12 || day < 1 || day > days_of_month[month - 1])
        return std::nullopt;
    const int before = year - 1;
    DayNumber days = 365 * (year - 1970) + (before / 4 - before / 100 + before / 400) - 477;
    for (int m = 1; m < month; ++m) days += days_of_month[m - 1];
    return days + day - 1;
}

NmeaRefusal read_message(const NmeaSentence& sentence, GgaMessage& gga) {
    return refusal_of([&] {
        const Fields fields(sentence);
        fields.need(9);
        gga = {};
        gga.time = fields.time(0);
        gga.has_position = read_position(fields, 1, gga.latitude_deg, gga.longitude_deg);
        gga.quality = fix_quality(fields.count(5, 99));
        gga.satellites = fields.count(6, 999);
        gga.hdop = fields.number(7, 0, most_dop);
        const auto altitude_m = fields.number(8, -most_height_m, most_height_m);
        gga.has_altitude = altitude_m.has_value();
        gga.altitude_m = altitude_m.value_or(0);
        gga.geoid_separation_m = fields.number(10, -most_height_m, most_height_m).value_or(0);
    });
}

NmeaRefusal read_message(const NmeaSentence& sentence, RmcMessage& rmc) {
    return refusal_of([&] {
        const Fields fields(sentence);
        fields.need(9);
        rmc = {};
        rmc.time = fields.time(0);
        rmc.valid = fields.letter(1, 'V') == 'A';
        rmc.has_position = read_position(fields, 2, rmc.latitude_deg, rmc.longitude_deg);
        rmc.speed_mps = knots(fields, 6);
        rmc.course_deg = fields.degrees(7);
        if (const std::string_view date = fields.text(8); !date.empty()) {
            if (date.size() != 6 || !Fields::all_digits(date)) throw Refused{NmeaRefusal::impossible_value};
            const int year = Fields::two_digits(date, 4);
            rmc.date = day_number(year + (year < 80 ? 2000 : 1900), Fields::two_digits(date, 2),
                                  Fields::two_digits(date, 0));
            if (!rmc.date) throw Refused{NmeaRefusal::impossible_value};
        }
        rmc.mode = fields.letter(11, 'A');
    });
}

NmeaRefusal read_message(const NmeaSentence& sentence, GstMessage& gst) {
    return refusal_of([&] {
        const Fields fields(sentence);
        fields.need(8);
        gst = {};
        gst.time = fields.time(0);
        const auto north_m = fields.number(5, 0, most_sigma_m), east_m = fields.number(6, 0, most_sigma_m),
                   up_m = fields.number(7, 0, most_sigma_m);
        if (!north_m || !east_m || !up_m) throw Refused{NmeaRefusal::missing_field};
        gst.sigma_enu_m = {*east_m, *north_m, *up_m};
    });
}

NmeaRefusal read_message(const NmeaSentence& sentence, VtgMessage& vtg) {
    return refusal_of([&] {
        const Fields fields(sentence);
        fields.need(6);
        vtg = {};
        vtg.course_deg = fields.degrees(0);
        vtg.speed_mps = knots(fields, 4);
    });
}

NmeaRefusal read_message(const NmeaSentence& sentence, GsaMessage& gsa) {
    return refusal_of([&] {
        const Fields fields(sentence);
        fields.need(17);
        gsa = {};
        gsa.hdop = fields.number(15, 0, most_dop);
        gsa.vdop = fields.number(16, 0, most_dop);
    });
}

NmeaRefusal read_message(const NmeaSentence& sentence, HdtMessage& hdt) {
    return refusal_of([&] {
        const Fields fields(sentence);
        fields.need(1);
        hdt = {};
        hdt.heading_deg = fields.degrees(0);
    });
}

NmeaRefusal read_message(const NmeaSentence& sentence, ZdaMessage& zda) {
    return refusal_of([&] {
        const Fields fields(sentence);
        fields.need(4);
        zda = {};
        zda.time = fields.time(0);
        if (fields.text(1).empty() || fields.text(2).empty() || fields.text(3).empty()) return;
        zda.date = day_number(fields.count(3, 9999), fields.count(2, 99), fields.count(1, 99));
        if (!zda.date) throw Refused{NmeaRefusal::impossible_value};
    });
}

}  // namespace loopline::gnss
