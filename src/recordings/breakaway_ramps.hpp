#pragma once

#include <vector>

#include "veridyn/math/types.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn {

/// A time at which a joint was at rest, was pushed more and more, and gave way.
struct Ramp {
  Eigen::Index rest;   ///< the first row
  Eigen::Index onset;  ///< the row at which it began to slide
  Eigen::Index end;    ///< the row after the last one before the next jump of the position
};

/// What counts as having left a rest, as sliding, and as having rested.
struct RampThresholds {
  double way;    ///< [rad], [m]
  double speed;  ///< [rad/s], [m/s]
  double rest;   ///< [s]
};

/// What they are where nothing else is asked for: 10 mrad or 1 mm, 50 mrad/s or 5 mm/s, 0.5 s.
RampThresholds ramp_thresholds(const Coordinate& joint);

/// The ramps of a joint: rests that end in sliding. A jump of the position (a new start) ends a
/// ramp; a leap of the effort begins a new one. Ramps start low: rests whose effort was above 60 %
/// of that at the onset are pauses. Rests pushed against an end of the range are none.
std::vector<Ramp> find_ramps(const Coordinate& joint, const VectorXd& time, const VectorXd& q,
                             const VectorXd& tau, const RampThresholds& limit);

/// Share of the rows at which the joint slides, by its positions a tenth of a second apart.
double sliding_share(const VectorXd& time, const VectorXd& q, double speed);

/// The mean effort of a tenth of a second around row k.
double effort_at(const VectorXd& time, const VectorXd& tau, Eigen::Index k);

}  // namespace veridyn
