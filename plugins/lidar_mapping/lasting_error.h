/// What of the error of each sweep adds up along the way, as the map is renewed with what it is matched with.
#pragma once

#include "lidar_mapping/registration.h"

namespace loopline::lidar_mapping {

/// Covariance of (shift, turn), map axes, that stays of Registration::by_scan. An error goes into the map,
/// but those of neighbouring sweeps are of the same surfaces, and are renewed with them only: 1 / their mean
/// age in sweeps (renewal theory). Where the surroundings hardly hold the sweep, though, what does is hardly
/// more than chance, and all of it stays.
Matrix6d what_lasts(const Registration& found);

/// Of the pose's error by the prediction, what was not there before: where the surroundings leave it free, the
/// error of the sweep before stays, and is no new one. `before`: as of_coming_back() takes it.
Matrix6d what_is_new(const Registration& found, const Matrix6d& before);

/// Of the motion that brings a pose back, to where the surroundings have it, after they left it free: the
/// part of the correction that, of all that the prediction is uncertain by, `before` has to answer for, which
/// is Registration::by_prediction of the sweep before, carried along. Where the surroundings have gone astray
/// with the vehicle, as at the end of a tunnel, there is no correction.
Matrix6d of_coming_back(const Registration& found, const Matrix6d& before);

}  // namespace loopline::lidar_mapping
