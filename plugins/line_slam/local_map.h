/// A part of the map that the filter works on, or worked on: the vehicle and the lines around it, with their
/// joint covariance. A filter that only knows its present local map costs the same in a large map as in a
/// small one; what the others have to learn from it is kept as a few small matrices, and told them when
/// somebody asks. Nothing is approximated: Guivant and Nebot 2001 for one local map, and here a chain of
/// them.
///
/// Why it is exact. Let y0 be the state of the local map when it was entered, y what it is now, and b
/// anything outside. Prediction, update and augmentation are linear in the error and never look at b, so that
///
///     P_yb = phi P_y0b,    P_bb(now) = P_bb - P_y0b^T psi P_y0b,    x_b(now) = x_b + P_y0b^T chi (1)
///
/// whatever b is. When a map is left, its kept part is the next map's y0; so (1) holds from map to map along
/// the chain. It is the adjoint form of a fixed-interval smoother (Bryson and Frazier 1963), and inverts no
/// covariance.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace loopline::line_slam {

/// phi, psi and chi of (1) since a local map was entered.
struct Compression {
    Eigen::MatrixXd phi;  ///< y by y0
    Eigen::MatrixXd psi;  ///< y0 by y0
    Eigen::VectorXd chi;  ///< y0

    /// Nothing has happened yet to a state of `size` numbers.
    static Compression none(Eigen::Index size);
};

struct LocalMap {
    static constexpr Eigen::Index head = 6;  ///< rows of the pose and of the wheel calibration

    std::vector<int> lines;  ///< ids, in the order of the rows after the head
    /// Map frame: about which errors are turned and rho is measured. Near the vehicle, so that what is of
    /// second order stays small: a heading that is corrected by 2 degrees moves what is 400 m from the origin
    /// by 0.3 m.
    Eigen::Vector2d origin_m = Eigen::Vector2d::Zero();
    Eigen::MatrixXd P;  ///< of head and lines, now or when the map was left
    Compression since_entered;
    std::vector<int> kept;  ///< positions in `lines` that the next map began with, in its order

    static Eigen::Index row(int position) { return head + 2 * position; }
    /// Rows of the head and of the lines at `positions`.
    static std::vector<Eigen::Index> rows_of(const std::vector<int>& positions);

    /// The map that begins with the present state of the lines at `positions`, which become `kept`.
    LocalMap leave(const std::vector<int>& positions);

    /// What lines from elsewhere had in common with the state that this map was entered with, and with each
    /// other then.
    struct Guests {
        std::vector<int> ids;
        std::vector<double> lever_m;  ///< way from the old origin to the new one along each guest
        Eigen::MatrixXd with_y0;      ///< y0 by guests
        Eigen::MatrixXd P;            ///< of the guests
    };
    /// Adds them, as if they had been there from the beginning. Returns what happened to their values
    /// meanwhile: (rho, alpha) of each.
    Eigen::VectorXd welcome(const Guests& guests);
    /// The lines at `positions` as guests of the next map, to which they are `kept` from now on; levers are
    /// left empty.
    Guests send_on(const std::vector<int>& positions);

    /// Writes the errors anew, about another origin. `tangent`: of a line by its id, as it was first
    /// estimated.
    template <class Tangent>
    void move_origin(const Eigen::Vector2d& new_origin_m, const Tangent& tangent) {
        const Eigen::Vector2d way_m = new_origin_m - origin_m;
        origin_m = new_origin_m;
        turn_head(way_m);
        for (std::size_t k = 0; k < lines.size(); ++k)
            shift_line(static_cast<int>(k), tangent(lines[k]).dot(way_m));
    }

    /// Without the line at `position`, which nobody kept.
    void remove(int position);

 private:
    void turn_head(const Eigen::Vector2d& way_m);
    void shift_line(int position, double lever_m);
};

/// The chain's two maps `first` and `second`, of which the first has no line that the second lacks, as one:
/// (1) from the entering of the first.
Compression joined(const LocalMap& first, const Compression& second);

}  // namespace loopline::line_slam
