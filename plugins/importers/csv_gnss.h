/// Receivers in tables, as CObservationGPS.
#pragma once

#include "gnss/local_frame.h"
#include "importers/csv_streams.h"

namespace loopline::csv {

/// Kind "gnss".
class GnssStream : public SensorStream {
 public:
    GnssStream(ColumnMap& map, const Section& section, const std::string& path,
               std::vector<Problem>& problems);
    bool next(const Clock& clock, Reading& reading) override;
    std::vector<std::string> complaints() const override;

 private:
    /// Nothing if the place can't be.
    std::optional<gnss::GnssFix> fix() const;
    gnss::FixQuality quality() const;
    bool take_place(gnss::GnssFix& fix) const;

    int latitude_, longitude_, east_, north_, height_, altitude_, speed_, course_, sigma_[3], variance_[3],
        quality_, satellites_, hdop_;
    std::optional<gnss::LocalFrame> frame_;
    std::size_t impossible_ = 0;
};

/// How far the clock of the tables is behind UTC by the fixes of a section with a column "utc": that of the
/// quickest ones, but for one in twenty, since a fix is known later than it was measured and never earlier.
/// `spread_s` is by how much that differs between the two halves of the log.
struct ClockOffset {
    StampNs offset_ns = 0;
    double spread_s = 0;
    std::size_t fixes = 0;
};
ClockOffset clock_offset(Rows& rows);

}  // namespace loopline::csv
