#pragma once

#include <vector>

#include "veridyn/math/types.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn {

/// One ramp: the joint rested, the effort rose, and the joint broke away.
struct Ramp {
  Eigen::Index rest;   ///< the first row
  Eigen::Index onset;  ///< first row of sliding
  Eigen::Index end;    ///< last row before the next jump of the position, plus one
};

/// Thresholds for the end of a rest, for sliding, and for the duration of a rest.
struct RampThresholds {
  double way;    ///< [rad], [m] displacement that ends a rest
  double speed;  ///< [rad/s], [m/s] smallest speed of sliding
  double rest;   ///< [s] shortest duration of a rest
};

/// Default thresholds: 10 mrad or 1 mm, 50 mrad/s or 5 mm/s, 0.5 s.
RampThresholds ramp_thresholds(const Coordinate& joint);

/// The ramps of a joint: rests that end in sliding. A jump of the position (a new start) ends a ramp; a sudden
/// rise of the effort begins a new one. Rests with more than 60 % of the effort at the onset are pauses within
/// a ramp and begin none. Rests against an end stop are excluded.
std::vector<Ramp> find_ramps(const Coordinate& joint, const VectorXd& time, const VectorXd& q,
                             const VectorXd& tau, const RampThresholds& limit);

/// Share of the rows in which the joint slides, by positions a tenth of a second apart.
double sliding_share(const VectorXd& time, const VectorXd& q, double speed);

/// Mean effort [N m], [N] over a tenth of a second around row k.
double effort_at(const VectorXd& time, const VectorXd& tau, Eigen::Index k);

}  // namespace veridyn
