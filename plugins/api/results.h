/// What a run hands to the writers when the log has ended.
#pragma once

#include <mrpt/serialization/CSerializable.h>

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "api/line_map.h"

namespace loopline {

/// One flat key of metrics.json.
using MetricValue = std::variant<std::int64_t, double, std::string, bool>;

/// A finished map. The writers know COccupancyGridMap2D, CPointsMap and its children, and CSimpleMap; its
/// name becomes the file name (`map.<name>.*` unless it is the only one of its kind).
struct NamedMap {
    std::string name;
    mrpt::serialization::CSerializable::Ptr map;
    /// A cloud of points in three dimensions, which has files (`map.<name>.*`) and pictures of its own.
    bool survey = false;
};

/// A key of an .ini as a log tells it.
struct CalibratedKey {
    std::string key;  ///< with no value it may stand for several: turn_left_*
    std::optional<double>
        value;  ///< in the key's unit; none: the log does not tell it, and the key is left out
    double standard_error = 0;  ///< of the value; 0: it is no estimate but belongs to the others
    std::string comment;        ///< what the value rests on, or why there is none
};

/// Keys of one section that a log tells, to take the place of those it was run with.
struct Calibration {
    std::string section;
    std::vector<std::string> remarks;  ///< sentences on all of it
    std::vector<CalibratedKey> keys;
};

struct Results {
    std::map<std::string, MetricValue> metrics;  ///< sorted: the same run writes the same bytes
    std::optional<LineMap> line_map;
    std::vector<NamedMap> maps;
    std::vector<Calibration> calibrations;  ///< by modules that can_calibrate(), where the run is for it
    /// Set, with one sentence, by a module whose estimate diverged or must be refused: exit code 4.
    std::optional<std::string> refused;
};

}  // namespace loopline
