/// The envelope of NMEA 0183: "$GPGGA,field,field*5A".
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace loopline::gnss {

/// Why a line, or what it says, is not taken.
enum class NmeaRefusal {
    none,
    no_sentence,     ///< there is no "$"
    too_long,        ///< more than longest_sentence characters
    odd_characters,  ///< outside of printable ASCII
    no_checksum,
    wrong_checksum,
    odd_name,         ///< not two letters of the talker and three of the sentence
    missing_field,    ///< ends before a field that it must have
    impossible_value  ///< a field that is no number, or beyond what it can be
};
constexpr std::size_t nmea_refusals = static_cast<std::size_t>(NmeaRefusal::impossible_value) + 1;
/// "a wrong checksum": completes "lines with ...".
const char* name_of(NmeaRefusal refusal);

/// The standard allows 82 characters; receivers that give more digits go beyond that.
constexpr std::size_t longest_sentence = 200;

/// Fields of a sentence. They point into the line.
struct NmeaSentence {
    std::string_view talker;  ///< "GP", "GN"; "P" of a maker's own sentence
    std::string_view type;    ///< "GGA"; of a maker's own, the rest of its name
    std::vector<std::string_view> fields;

    bool is(std::string_view name) const { return type == name && talker != "P"; }
    /// Empty beyond the last.
    std::string_view field(std::size_t index) const {
        return index < fields.size() ? fields[index] : std::string_view{};
    }
};

/// Exclusive or of all characters: what stands between "$" and "*".
std::uint8_t nmea_checksum(std::string_view characters);

/// Reads the sentence that begins at the line's last "$"; what a logger wrote before that is skipped. The
/// checksum has to be there, and right. `sentence` is good only if none is returned.
NmeaRefusal read_sentence(std::string_view line, NmeaSentence& sentence);

}  // namespace loopline::gnss
