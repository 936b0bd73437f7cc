/// Landmarks in tables, as CObservationBearingRange.
#pragma once

#include <mrpt/obs/CObservationBearingRange.h>

#include "importers/csv_streams.h"

namespace loopline::csv {

/// Kind "landmarks": a line for each that was seen; those of one time are one scan.
class LandmarkStream : public SensorStream {
 public:
    LandmarkStream(ColumnMap& map, const Section& section, const std::string& path,
                   std::vector<Problem>& problems);
    bool next(const Clock& clock, Reading& reading) override;
    std::vector<std::string> complaints() const override;

 private:
    bool next_possible();
    mrpt::obs::CObservationBearingRange::TMeasurement measurement() const;

    int range_, bearing_, diameter_;
    bool is_ahead_ = false;  ///< the current line is of the next scan
    std::size_t impossible_ = 0;
};

}  // namespace loopline::csv
