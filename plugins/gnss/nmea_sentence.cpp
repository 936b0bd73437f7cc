#include "gnss/nmea_sentence.h"

#include <algorithm>

namespace loopline::gnss {
namespace {

int hex_digit(char c) {
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'A' && c <= 'F') return c - 'A' + 10;
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    return -1;
}

bool is_upper(char c) {
    return (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
}

void split(std::string_view text, std::vector<std::string_view>& fields) {
    fields.clear();
    while (true) {
        const std::size_t comma = text.find(',');
        fields.push_back(text.substr(0, comma));
        if (comma == std::string_view::npos) return;
        text.remove_prefix(comma + 1);
    }
}

}  // namespace

const char* name_of(NmeaRefusal refusal) {
    switch (refusal) {
        case NmeaRefusal::none:
            return "nothing wrong";
        case NmeaRefusal::no_sentence:
            return "no sentence";
        case NmeaRefusal::too_long:
            return "too many characters";
        case NmeaRefusal::odd_characters:
            return "characters that are not printable ASCII";
        case NmeaRefusal::no_checksum:
            return "no checksum";
        case NmeaRefusal::wrong_checksum:
            return "a wrong checksum";
        case NmeaRefusal::odd_name:
            return "no name of a sentence";
        case NmeaRefusal::missing_field:
            return "a field missing";
        case NmeaRefusal::impossible_value:
            break;
    }
    return "an impossible value";
}

std::uint8_t nmea_checksum(std::string_view characters) {
    std::uint8_t sum = 0;
    for (const char c : characters) sum = static_cast<std::uint8_t>(sum ^ static_cast<std::uint8_t>(c));
    return sum;
}

NmeaRefusal read_sentence(std::string_view line, NmeaSentence& sentence) {
    const std::size_t end = line.find_last_not_of(" \t\r\n");
    line = line.substr(0, end == std::string_view::npos ? 0 : end + 1);
    const std::size_t dollar = line.rfind('$');
    if (dollar == std::string_view::npos) return NmeaRefusal::no_sentence;
    line.remove_prefix(dollar + 1);
    if (line.size() > longest_sentence) return NmeaRefusal::too_long;
    if (std::any_of(line.begin(), line.end(), [](char c) { return c < 0x20 || c > 0x7e; }))
        return NmeaRefusal::odd_characters;

    const std::size_t star = line.rfind('*');
    if (star == std::string_view::npos || line.size() != star + 3) return NmeaRefusal::no_checksum;
    const int high = hex_digit(line[star + 1]), low = hex_digit(line[star + 2]);
    if (high < 0 || low < 0) return NmeaRefusal::no_checksum;
    line = line.substr(0, star);
    if (nmea_checksum(line) != 16 * high + low) return NmeaRefusal::wrong_checksum;

    split(line, sentence.fields);
    const std::string_view name = sentence.fields.front();
    if (name.size() < 3 || !std::all_of(name.begin(), name.end(), is_upper)) return NmeaRefusal::odd_name;
    const bool own = name.front() == 'P';
    if (!own && name.size() != 5) return NmeaRefusal::odd_name;
    sentence.talker = name.substr(0, own ? 1 : 2);
    sentence.type = name.substr(own ? 1 : 2);
    sentence.fields.erase(sentence.fields.begin());
    return NmeaRefusal::none;
}

}  // namespace loopline::gnss
