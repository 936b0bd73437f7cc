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

/// A finished map. The writers know COccupancyGridMap2D, CPointsMap and its children, and CSimpleMap; its name becomes
/// the file name (`map.<name>.*` unless it is the only one of its kind).
struct NamedMap {
    std::string name;
    mrpt::serialization::CSerializable::Ptr map;
    /// A cloud of points in three dimensions, which has files (`map.<name>.*`) and pictures of its own.
    bool survey = false;
};

struct Results {
    std::map<std::string, MetricValue> metrics;  ///< sorted: the same run writes the same bytes
    std::optional<LineMap> line_map;
    std::vector<NamedMap> maps;
    /// Set, with one sentence, by a module whose estimate diverged or must be refused: exit code 4.
    std::optional<std::string> refused;
};

}  // namespace loopline
