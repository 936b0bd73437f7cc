/// Line EKF-SLAM, one scan at a time: reads like section 3 of Hu, Chen, Zhang 2012.
#pragma once

#include <vector>

#include "line_slam/association.h"
#include "line_slam/ekf.h"
#include "line_slam/history.h"
#include "line_slam/line_grid.h"
#include "line_slam/map_lines.h"
#include "line_slam/motion_model.h"
#include "line_slam/place_recognition.h"
#include "line_slam/tentative_lines.h"

namespace loopline::line_slam {

struct LineSlamParameters {
    DriveParameters drive;
    Feature feature = Feature::line;
    Update update = Update::joint;
    AssociationParameters association;
    TentativeParameters tentative;
    double sigma_wall_m = 0.015;  ///< how far a wall is from straight
    RecognitionParameters recognition;
    double drift_m_per_m = 0.02;  ///< what place recognition reckons with, since a place was seen
    double drift_rad_per_m = 0.002;
    double recent_m = 5;            ///< of the path, whose lines are matched with old ones
    double wake_m = 5;              ///< of the path around an old place that is seen again
    double wall_correlation_m = 2;  ///< of the path, over which a wall's unevenness looks the same
    double max_repetitions = 2000;  ///< that it counts for, at most
    double overconfidence =
        10;                   ///< of the filter after a long way, that a recognised place may bring to light
    double slip_factor = 10;  ///< by which the noise of slipping wheels exceeds the model's
    double max_slip_turn_rad = 2 * M_PI / 180;  ///< of a sigma of it, for other walls to be out of reach
    double recognition_every_m = 0.5;           ///< of the path
    double active_m = 3;                        ///< of the path, whose lines stay active
};

struct LineSlamCounts {
    std::int64_t updates = 0, predictions = 0, associations = 0, rejected = 0, merged = 0, recognised = 0,
                 refused = 0, slips = 0, dropped = 0;
};

enum class SlamStatus { good, diverged };

class LineEkfSlam {
 public:
    explicit LineEkfSlam(const LineSlamParameters& parameters);

    /// One step of the filter: the motion since the step before, and the lines of the scan at its end in the
    /// base frame.
    SlamStatus step(const std::vector<MotionPiece>& motion, std::vector<LineObservation> observations);
    /// The same with a motion by measured wheels in one piece.
    SlamStatus step(const Pose2& T_previous_base, std::vector<LineObservation> observations);

    const Ekf& filter() const { return filter_; }
    const MapLineRecords& records() const { return records_; }
    const History& history() const { return history_; }
    const LineSlamCounts& counts() const { return counts_; }

 private:
    template <class Archive>
    friend void fields(Archive&, LineEkfSlam&);
    /// Returns the length of the way.
    double predict(const std::vector<MotionPiece>& motion);
    void discount_repetition(double way_m, std::vector<LineObservation>& observations) const;
    Association associate_or_doubt_wheels(const std::vector<LineObservation>& observations, double way_m);
    bool slip_is_small() const;
    bool tells_of_slip(const Association& with_slip, const Association& without,
                       double path_at_last_step_m) const;
    bool may_be_seen(int id, const std::vector<LineObservation>& observations, double reach_m) const;
    void activate_surroundings(const std::vector<LineObservation>& observations);
    void remember_seen(const std::vector<Pairing>& pairings,
                       const std::vector<LineObservation>& observations);
    void augment_map(const Association& association, const std::vector<LineObservation>& observations,
                     std::vector<int>& tracks);
    void recognise_old_place();
    std::optional<Recognition> search_old_place();
    std::vector<int> lines_since(double way_m) const;
    void remember_place(int id, int place);
    void put_on_grid(int id);
    void wake_neighbourhood();
    void drop_chance_lines();
    bool merge(const Recognition& recognition);

    LineSlamParameters parameters_;
    Ekf filter_;
    MapLineRecords records_;
    TentativeLines tentative_;
    History history_;
    LineSlamCounts counts_;
    std::vector<char> near_;  ///< working memory of wake_neighbourhood(), per metre of the path
    std::vector<int> awake_;  ///< lines that a scan may be matched with, ascending
    std::vector<int> young_;  ///< lines that may still turn out to be chance
    std::vector<std::vector<int>> lines_at_;  ///< by whole metres of the path: lines that were seen there
    LineGrid grid_;
    double path_m_ = 0;
    double recognised_at_m_ = 0, woken_at_m_ = 0;  ///< path at the last attempt
    std::size_t last_pairings_ = 0;
    int scan_ = 0;
    std::size_t active_limit_ = 20;  ///< of lines, before the surroundings are chosen anew
};

}  // namespace loopline::line_slam
