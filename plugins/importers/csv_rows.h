/// The lines of a table as a map says what is in them: numbers in SI, times in nanoseconds.
#pragma once

#include <string>
#include <vector>

#include "importers/csv_map.h"
#include "importers/csv_table.h"

namespace loopline::csv {

/// Lines in which one of the map's columns is missing, no number or not finite are left out and counted.
class Rows {
 public:
    static constexpr int none = -1;

    /// Looks up the columns of `section`, those of its second file if `second`. What the table does not have
    /// goes to `problems`. Throws std::runtime_error if the table can't be read.
    Rows(ColumnMap& map, const Section& section, const std::string& path, bool second,
         std::vector<Problem>& problems);

    /// The next good line; false at the end.
    bool next();
    StampNs time_ns() const { return times_ns_[0]; }
    /// Where values of a key stand in each line; `none` if the map does not give the key.
    int slot(const std::string& key) const;
    double value(int slot) const { return values_[static_cast<std::size_t>(slot)]; }
    double value_or(int slot, double other) const { return slot == none ? other : value(slot); }
    /// Of the column "utc".
    StampNs utc_ns() const { return times_ns_[1]; }
    bool has_utc() const { return utc_; }

    /// Sentences about what was left out, and about times that go back.
    std::vector<std::string> complaints() const;

 private:
    struct Column {
        std::string key;
        std::size_t index;
        double factor;
    };
    struct TimeColumn {
        std::size_t index;
        int power_of_ten;  ///< of its unit, in s
    };
    void find(ColumnMap& map, const Section& section, const ColumnKey& key, std::vector<Problem>& problems);
    bool take_line();

    Table table_;
    std::string name_;
    std::vector<Column> columns_;
    std::vector<TimeColumn> time_columns_;  ///< time, and utc where there is one
    std::vector<double> values_;
    std::vector<StampNs> times_ns_;
    bool utc_ = false;
    std::size_t good_ = 0, left_out_ = 0, first_left_out_ = 0, backwards_ = 0;
    StampNs latest_ns_ = 0;
};

}  // namespace loopline::csv
