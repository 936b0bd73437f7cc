/// Parameters that are declared once: name, unit, type, default, allowed range and one sentence, bound to the
/// member of the struct that uses them. That one declaration feeds reading, range checks, "did you mean",
/// `loopline describe`, docs/ini-reference.md and the commented default .ini. (Idea: libpointmatcher's
/// Parametrizable.)
#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace loopline {

/// An allowed interval, both ends included; in the unit of the key.
struct Range {
    double min = -std::numeric_limits<double>::infinity();
    double max = std::numeric_limits<double>::infinity();
    static Range any() { return {}; }
    static Range at_least(double min) { return {min, std::numeric_limits<double>::infinity()}; }
    static Range positive() { return at_least(std::numeric_limits<double>::denorm_min()); }
};

enum class ParameterKind { real, integer, boolean, choice, text, path, list, path_list, rows };

/// Whether a named file has to be there before anything runs.
enum class FileNeed { optional, must_exist };

/// One declared parameter. `parse` takes the text after "=" and either stores the value, or returns what was
/// wrong with it as a clause that fits after the key ("is not a number", "must be at least 0").
struct Parameter {
    std::string name;  ///< the key, with its unit as suffix: sigma_range_m, gate_deg
    ParameterKind kind;
    std::string unit;      ///< from the suffix: m, s, deg, hz, mps, mps2, dps; empty if dimensionless
    std::string allowed;   ///< "0 .. 1", "foot_point | infinite_line"; empty if anything goes
    std::string sentence;  ///< what it does, one sentence
    std::string default_text;
    std::function<std::optional<std::string>(const std::string& text)> parse;
    std::function<std::string()> print;  ///< the present value, as it would stand in an .ini
    std::vector<std::string> choices{};  ///< of a choice: the words that are allowed
    FileNeed need = FileNeed::optional;  ///< of a path or path list
    /// Of rows: the key may stand several times, `parse` adds a row each time, and this gives them as they would stand
    /// in an .ini.
    std::function<std::vector<std::string>()> print_rows{};
};

/// How many numbers a row has: `first`, or more by whole multiples of `more`.
struct RowShape {
    std::size_t first = 1;
    std::size_t more = 0;
};

/// The parameters of one .ini section, in the order of declaration. Bound variables must outlive the table,
/// and hold their default when they are declared.
class ParameterTable {
 public:
    ParameterTable(std::string section, std::string sentence)
        : section_(std::move(section)), sentence_(std::move(sentence)) {}

    ParameterTable& real(const std::string& name, double& value, Range range, const std::string& sentence);
    /// Key in degrees (`_deg`) or degrees a second (`_dps`), variable in radians. Twelve digits of the
    /// degrees count: the variable is set to what the printed text reads back as, so that an effective .ini
    /// repeats a run bit for bit.
    ParameterTable& angle(const std::string& name, double& value_rad, Range range_deg,
                          const std::string& sentence);
    ParameterTable& integer(const std::string& name, int& value, Range range, const std::string& sentence);
    ParameterTable& seed(const std::string& name, std::uint64_t& value, const std::string& sentence);
    ParameterTable& boolean(const std::string& name, bool& value, const std::string& sentence);
    ParameterTable& text(const std::string& name, std::string& value, const std::string& sentence);
    /// A file or folder: ${NAME} is expanded, and a relative one is taken from the folder of the .ini, by the
    /// reader, which also reports one that `must_exist` and does not.
    ParameterTable& path(const std::string& name, std::string& value, const std::string& sentence,
                         FileNeed need = FileNeed::optional);
    /// Words separated by blanks or commas.
    ParameterTable& list(const std::string& name, std::vector<std::string>& value,
                         const std::string& sentence);
    /// Paths, separated by ";" since a path may hold blanks and commas; each handled like path().
    ParameterTable& paths(const std::string& name, std::vector<std::string>& value,
                          const std::string& sentence, FileNeed need = FileNeed::optional);

    /// A key that may stand several times, with a row of numbers each time, separated by blanks or commas. `form` names
    /// them: "x y x y ...".
    ParameterTable& rows(const std::string& name, std::vector<std::vector<double>>& value, RowShape shape,
                         const std::string& form, const std::string& sentence);

    template <class Enum>
    ParameterTable& choice(const std::string& name, Enum& value,
                           const std::vector<std::pair<std::string, Enum>>& choices,
                           const std::string& sentence) {
        std::vector<std::string> names;
        for (const auto& c : choices) names.push_back(c.first);
        return add_choice(
            name, names, [&value, choices](std::size_t i) { value = choices[i].second; },
            [&value, choices] {
                std::size_t i = 0;
                while (i + 1 < choices.size() && choices[i].second != value) ++i;
                return i;
            },
            sentence);
    }

    const std::string& section() const { return section_; }
    const std::string& sentence() const { return sentence_; }
    const std::vector<Parameter>& parameters() const { return parameters_; }
    const Parameter* find(const std::string& name) const;

 private:
    ParameterTable& add(Parameter parameter);
    ParameterTable& add_words(const std::string& name, ParameterKind kind, std::vector<std::string>& value,
                              const std::string& separators, const std::string& joint,
                              const std::string& sentence);
    ParameterTable& add_choice(const std::string& name, const std::vector<std::string>& names,
                               std::function<void(std::size_t)> set, std::function<std::size_t()> get,
                               const std::string& sentence);

    std::string section_;
    std::string sentence_;
    std::vector<Parameter> parameters_;
};

/// Shortest decimal text that reads back to the same double; "." whatever the locale.
std::string number_text(double value);
/// The words between any of `separators`, without the blanks around them; none is empty.
std::vector<std::string> split_words(const std::string& text, const std::string& separators);
/// The whole text as a finite number, "." whatever the locale; `nullopt` if it is anything else.
std::optional<double> number_from_text(const std::string& text);

}  // namespace loopline
