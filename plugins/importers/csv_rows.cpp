#include "importers/csv_rows.h"

#include <cmath>

#include "config/did_you_mean.h"

namespace loopline::csv {

Rows::Rows(ColumnMap& map, const Section& section, const std::string& path, bool second,
           std::vector<Problem>& problems)
    : table_(path), name_(section.name) {
    const bool two_files = !section.acceleration_file.empty();
    const ColumnKey* time = second && section.has("acceleration_time") ? section.column("acceleration_time")
                                                                       : section.column("time");
    const ColumnKey* utc = section.column("utc");
    find(map, section, *time, problems);
    if (utc && !second) {
        find(map, section, *utc, problems);
        utc_ = true;
    }
    for (const ColumnKey& key : section.columns)
        if (!key.text.empty() && key.quantity != Quantity::time &&
            (second ? key.of_second_file : !(two_files && key.of_second_file)))
            find(map, section, key, problems);
    values_.resize(columns_.size());
    times_ns_.resize(2);
}

void Rows::find(ColumnMap& map, const Section& section, const ColumnKey& key,
                std::vector<Problem>& problems) {
    const auto index = table_.find(key.choice);
    if (!index) {
        std::string sentence = "[" + section.name + "] " + key.key + " ";
        if (key.choice.number)
            sentence += "is column " + std::to_string(*key.choice.number + 1) + ", and " + table_.path() +
                        " has " + std::to_string(table_.columns());
        else if (table_.header().empty())
            sentence += "names the column \"" + key.choice.name + "\", and " + table_.path() +
                        " has no line of names; write \"column 1\" for its first";
        else
            sentence += "names the column \"" + key.choice.name + "\", which " + table_.path() +
                        " does not have" +
                        did_you_mean(key.choice.name, table_.header(),
                                     "; its columns are " + listing(table_.header()));
        problems.emplace_back(map.origin(section, key.key), sentence);
    } else if (key.quantity == Quantity::time) {
        time_columns_.push_back({*index, static_cast<int>(std::lround(std::log10(key.choice.factor)))});
    } else {
        columns_.push_back({key.key, *index, key.choice.factor});
    }
}

int Rows::slot(const std::string& key) const {
    for (std::size_t i = 0; i < columns_.size(); ++i)
        if (columns_[i].key == key) return static_cast<int>(i);
    return none;
}

bool Rows::take_line() {
    for (std::size_t i = 0; i < time_columns_.size(); ++i) {
        const auto time = time_from_text(table_.cell(time_columns_[i].index), time_columns_[i].power_of_ten);
        if (!time) return false;
        times_ns_[i] = *time;
    }
    for (std::size_t i = 0; i < columns_.size(); ++i) {
        const auto number = number_from_text(std::string(table_.cell(columns_[i].index)));
        if (!number || !std::isfinite(*number)) return false;
        values_[i] = *number * columns_[i].factor;
    }
    return true;
}

bool Rows::next() {
    while (table_.next()) {
        if (!take_line()) {
            if (left_out_++ == 0) first_left_out_ = table_.line();
            continue;
        }
        if (good_++ > 0 && time_ns() < latest_ns_) ++backwards_;
        latest_ns_ = time_ns();
        return true;
    }
    return false;
}

std::vector<std::string> Rows::complaints() const {
    std::vector<std::string> sentences;
    if (left_out_ > 0)
        sentences.push_back(
            table_.path() + ":" + std::to_string(first_left_out_) +
            (left_out_ == 1 ? ": a line that lacks a number"
                            : ": the first of " + std::to_string(left_out_) + " lines that lack a number") +
            " of [" + name_ + "] and " + (left_out_ == 1 ? "is" : "are") + " left out");
    if (backwards_ > 0)
        sentences.push_back(table_.path() + ": the times of [" + name_ + "] go back " +
                            std::to_string(backwards_) + (backwards_ == 1 ? " time" : " times") +
                            "; the file's order is kept");
    return sentences;
}

}  // namespace loopline::csv
