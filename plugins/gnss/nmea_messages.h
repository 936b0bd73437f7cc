/// What the sentences of NMEA 0183 say that concern a fix.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>

#include "gnss/gnss_fix.h"
#include "gnss/nmea_sentence.h"

namespace loopline::gnss {

/// Nanoseconds since midnight UTC; a leap second is the day's last + 1 s.
using TimeOfDayNs = std::int64_t;

/// Days since 1970-01-01.
using DayNumber = std::int64_t;
/// None if there is no such day.
std::optional<DayNumber> day_number(int year, int month, int day);

/// $--GGA,hhmmss.ss,ddmm.mm,N,dddmm.mm,E,quality,satellites,hdop,altitude,M,geoid,M,age,station
struct GgaMessage {
    std::optional<TimeOfDayNs> time;
    bool has_position = false, has_altitude = false;
    double latitude_deg = 0, longitude_deg = 0;
    FixQuality quality = FixQuality::invalid;
    int satellites = 0;
    std::optional<double> hdop;
    double altitude_m = 0;          ///< above the geoid
    double geoid_separation_m = 0;  ///< geoid above the ellipsoid
};

/// $--RMC,hhmmss.ss,A,ddmm.mm,N,dddmm.mm,E,knots,course,ddmmyy,variation,E,mode
struct RmcMessage {
    std::optional<TimeOfDayNs> time;
    bool valid = false, has_position = false;
    double latitude_deg = 0, longitude_deg = 0;
    std::optional<double> speed_mps, course_deg;  ///< clockwise from true north
    std::optional<DayNumber> date;
    char mode =
        'A';  ///< of position: A alone, D differential, R fixed, F float, E dead reckoning, M entered, S, N
};

/// $--GST,hhmmss.ss,rms,major,minor,orientation,latitude,longitude,altitude: standard deviations in m
struct GstMessage {
    std::optional<TimeOfDayNs> time;
    Eigen::Vector3d sigma_enu_m = Eigen::Vector3d::Zero();
};

/// $--VTG,course,T,course,M,knots,N,km/h,K,mode
struct VtgMessage {
    std::optional<double> speed_mps, course_deg;
};

/// $--GSA,selection,dimensions,12 satellites,pdop,hdop,vdop
struct GsaMessage {
    std::optional<double> hdop, vdop;
};

/// $--HDT,heading,T
struct HdtMessage {
    std::optional<double> heading_deg;  ///< clockwise from true north
};

/// $--ZDA,hhmmss.ss,day,month,year,zone
struct ZdaMessage {
    std::optional<TimeOfDayNs> time;
    std::optional<DayNumber> date;
};

/// Each reads a sentence of its type. Fields that are left empty are not there; what must be there and is
/// not, or can't be, is refused, and the message is then nothing.
NmeaRefusal read_message(const NmeaSentence& sentence, GgaMessage& gga);
NmeaRefusal read_message(const NmeaSentence& sentence, RmcMessage& rmc);
NmeaRefusal read_message(const NmeaSentence& sentence, GstMessage& gst);
NmeaRefusal read_message(const NmeaSentence& sentence, VtgMessage& vtg);
NmeaRefusal read_message(const NmeaSentence& sentence, GsaMessage& gsa);
NmeaRefusal read_message(const NmeaSentence& sentence, HdtMessage& hdt);
NmeaRefusal read_message(const NmeaSentence& sentence, ZdaMessage& zda);

}  // namespace loopline::gnss
