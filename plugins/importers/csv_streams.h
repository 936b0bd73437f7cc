/// Tables as streams of observations, one for each sensor of a column map.
#pragma once

#include <mrpt/obs/CObservation.h>

#include <memory>
#include <string>
#include <vector>

#include "importers/csv_rows.h"

namespace loopline::csv {

/// From the times of the tables to those of the rawlog.
struct Clock {
    StampNs offset_ns = 0;
    StampNs utc_ns(StampNs table_ns) const { return table_ns + offset_ns; }
};

struct Reading {
    StampNs known_ns = 0;  ///< when the log's computer had it: its place in the rawlog
    mrpt::obs::CObservation::Ptr observation;
};

class SensorStream {
 public:
    SensorStream(ColumnMap& map, const Section& section, const std::string& path,
                 std::vector<Problem>& problems)
        : section_(section), rows_(map, section, path, false, problems) {}
    virtual ~SensorStream() = default;
    /// The next reading, in the file's order; false at the end.
    virtual bool next(const Clock& clock, Reading& reading) = 0;
    virtual std::vector<std::string> complaints() const { return rows_.complaints(); }
    const Section& section() const { return section_; }

 protected:
    const Section& section_;
    Rows rows_;
};

/// Of any kind but a reference; `second_path` is that of acceleration_file, or empty.
std::unique_ptr<SensorStream> make_stream(ColumnMap& map, const Section& section, const std::string& path,
                                          const std::string& second_path, std::vector<Problem>& problems);

}  // namespace loopline::csv
