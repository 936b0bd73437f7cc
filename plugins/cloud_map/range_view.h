/// What a sweep saw in each direction, to ask it later whether a place was empty then.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "cloud_map/sweep_motion.h"

namespace loopline::cloud_map {

/// What a sweep says of a place.
enum class Evidence : std::uint8_t {
    none,    ///< it did not look there, or something stood in between
    seen,    ///< something was there
    through  ///< its beams about the place all went on beyond it
};

struct ViewSettings {
    double reach_m = 50;    ///< places farther from the lidar are not judged: its beams are too far apart
    double margin_m = 0.3;  ///< by which beams must go beyond a place
    double margin_per_m = 0.01;   ///< and more, for each metre of range
    double sigma_slope = 0.0015;  ///< so far off a place may be across its beam, for each metre of range
};

/// A range image, as Removert (Kim, Kim 2020) compares them, with the lidar's own rings as rows; each part of
/// the sweep from where the lidar was then.
class RangeView {
 public:
    RangeView() = default;
    RangeView(const lidar::SpinningScan& scan, const SweepMotion& motion);

    /// Of the lidar in the middle of the sweep.
    const Eigen::Vector3d& origin_m() const { return origin_m_; }
    /// `from_origin_m`: the place in the map's axes, from origin_m().
    ///
    /// The beams about a place are those of the rings above and below it, and of its column and one more on
    /// each side. All of them must have gone beyond it, so that a surface that is met
    /// at a grazing angle is safe: of two rings on the same ground one is always nearer than any place
    /// between them. So are posts, which hide in one column or the next.
    Evidence look(const Eigen::Vector3f& from_origin_m, const ViewSettings& settings) const;

 private:
    template <class Archive>
    friend void fields(Archive&, RangeView&);
    friend class ClearImage;
    struct Sector {
        Eigen::Matrix3f R_lidar_map = Eigen::Matrix3f::Identity();
        Eigen::Vector3f from_origin_m = Eigen::Vector3f::Zero();  ///< of the lidar
    };
    static constexpr int sectors = 64;
    static constexpr float range_unit_m = 0.004f;

    void find_slopes(const lidar::SpinningScan& scan);
    void find_sectors(const lidar::SpinningScan& scan, const std::vector<float>& turns,
                      const SweepMotion& motion);
    void fill(const lidar::SpinningScan& scan, const std::vector<float>& turns);
    /// The last ring that lies above a slope; -1 if none does, rings() - 1 if all do.
    int ring_above(float slope) const;
    int rings() const { return static_cast<int>(slopes_.size()); }

    Eigen::Vector3d origin_m_ = Eigen::Vector3d::Zero();
    std::vector<Sector> sectors_;        ///< by azimuth
    std::vector<float> slopes_;          ///< of the rings, from the highest
    std::vector<std::int16_t> ring_at_;  ///< by slope: the last ring that lies above the whole of a bin
    float first_slope_ = 0, bins_per_slope_ = 0;
    int columns_ = 0;
    std::vector<std::uint16_t> ranges_;  ///< row by row, in range_unit_m; 0: nothing came back
};

}  // namespace loopline::cloud_map
