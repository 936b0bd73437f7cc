/// Poses and what was measured between them: the most likely poses given all of it (Lu and Milios 1997), by
/// sparse least squares.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

#include "api/pose2.h"

namespace loopline::grid_slam {

/// Pose `to` in the frame of pose `from`, with the information on (x, y, phi) along the axes of `from`.
struct Constraint {
    enum class Kind : std::uint8_t {
        motion,
        match,
        loop,
        named
    };  ///< named: a loop that a person vouches for
    /// Whether it counts less where it disagrees with the others.
    bool may_be_wrong() const { return kind == Kind::match || kind == Kind::loop; }
    std::uint32_t from = 0, to = 0;
    Pose2 T_from_to;
    Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
    Kind kind = Kind::motion;
};

/// e = (R_from' (t_to - t_from) - t, phi_to - phi_from - phi).
Eigen::Vector3d residual(const Constraint& constraint, const Pose2& T_map_from, const Pose2& T_map_to);

struct GraphSettings {
    int iterations = 10;
    double enough_m = 1e-4;  ///< no pose moves more (nor turns more, in rad): done
    double loss_scale = 3;   ///< residual in sigmas at which a match begins to count less (Cauchy)
};

/// Gauss-Newton on all poses but the first one, which stays. An iteration is a step of its own, so that a run
/// can go on between two of them.
class GraphOptimiser {
 public:
    GraphOptimiser(std::vector<Pose2> poses, std::vector<Constraint> constraints,
                   const GraphSettings& settings);
    ~GraphOptimiser();
    GraphOptimiser(GraphOptimiser&&) noexcept;
    GraphOptimiser& operator=(GraphOptimiser&&) noexcept;

    /// False when it has come to its end.
    bool iterate();
    bool good() const { return good_; }
    int iterations() const { return iterations_; }
    /// Sum of e' information e, that of matches under the loss, before the last iteration.
    double cost() const { return cost_; }
    const std::vector<Pose2>& poses() const { return poses_; }
    std::size_t constraints() const { return constraints_.size(); }
    /// After so many iterations in an earlier process.
    void go_on_from(int iterations, bool good) {
        iterations_ = iterations;
        good_ = good;
    }

    /// Of (x, y, phi) of each pose given the first one, at the present poses; empty if they can't be told.
    std::vector<Eigen::Matrix3d> covariances();

 private:
    class NormalEquations;
    std::vector<Pose2> poses_;
    std::vector<Constraint> constraints_;
    GraphSettings settings_;
    std::unique_ptr<NormalEquations> equations_;
    int iterations_ = 0;
    double cost_ = 0;
    bool good_ = true;
};

}  // namespace loopline::grid_slam
