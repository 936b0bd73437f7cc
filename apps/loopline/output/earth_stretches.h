/// A path on the Earth, cut where it crosses the meridian of 180 degrees.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

#include "api/trajectory.h"
#include "gnss/geo_reference.h"
#include "output/tum.h"

namespace loopline {

struct EarthVertex {
    StampNs stamp_ns = 0;
    gnss::Geodetic place;
    /// Standard deviations along east, north and up, and of the heading; not finite where they are not known.
    Eigen::Vector3d sigma_enu_m = Eigen::Vector3d::Zero();
    double sigma_heading_rad = 0;
};

/// Vertices of a trajectory, which outlives this; computed anew whenever they are asked for, so that a path
/// may be longer than memory.
class EarthStretches {
 public:
    EarthStretches(const Trajectory& trajectory, const gnss::GeoReference& reference, Estimate estimate);

    /// Stretches between crossings, each of at least one vertex; where a path is cut, both sides have a
    /// vertex on the meridian, interpolated (RFC 7946, section 3.1.9).
    std::size_t size() const { return stretches_.size(); }
    std::size_t vertices(std::size_t stretch) const;
    using Use = std::function<void(const EarthVertex&)>;
    void for_each(std::size_t stretch, const Use& use) const;
    /// Poses that are not finite, which are no vertices.
    std::size_t left_out() const { return left_out_; }

 private:
    struct Stretch {
        std::size_t first = 0, end = 0;            ///< entries of the trajectory
        std::size_t poses = 0;                     ///< of them, those that are finite
        std::optional<EarthVertex> before, after;  ///< on the meridian
    };
    std::optional<EarthVertex> vertex(std::size_t index) const;

    const Trajectory* trajectory_;
    gnss::GeoReference reference_;
    Estimate estimate_;
    std::vector<Stretch> stretches_;
    std::size_t left_out_ = 0;
};

}  // namespace loopline
