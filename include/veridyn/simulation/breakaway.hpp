#pragma once

#include <string>
#include <vector>

#include "veridyn/simulation/replay.hpp"

namespace veridyn {

struct BreakawayOptions {
  int joint = 0;     ///< from 0
  double way = 0.0;  ///< [rad], [m] after which it has left its rest; 0: 10 mrad or 1 mm
  /// [rad/s], [m/s] above which it slides; 0: 50 mrad/s or 5 mm/s. Friction with a memory gives by
  /// a millimetre before it does, at a creep.
  double speed = 0.0;
  double rest = 0.5;  ///< [s] for which it must have stood
};

/// One time at which the joint was at rest, was pushed more and more, and gave way.
struct BreakawayEvent {
  double rest_from = 0.0;  ///< [s] since the recording began
  int direction = 0;       ///< in which it went: +1, -1
  double recorded_at = 0.0;
  double recorded = 0.0;  ///< [N m], [N] effort when it began to slide
  double simulated_at = 0.0;
  double simulated = 0.0;  ///< NaN: the model did not slide, though pushed for longer
};

struct Breakaway {
  int joint = 0;       ///< from 0
  double speed = 0.0;  ///< [rad/s], [m/s] above which it slides
  std::vector<BreakawayEvent> events;
  /// Medians of each direction, [N m], [N]; NaN where there are none.
  double recorded_forward = 0.0, recorded_backward = 0.0;
  double simulated_forward = 0.0, simulated_backward = 0.0;
  VectorXd simulated_q;  ///< (rows) of the joint; NaN where nothing was simulated

  /// Every ramp with both efforts, and the medians, as text.
  /// @param joint  the coordinate. @param recording  what the recording is called.
  std::string report(const Coordinate& joint, const std::string& recording) const;
};

/// The efforts at which one joint breaks away in a recording of slow ramps, that is at which it
/// begins to slide, and those at which a model does that is pushed alike: it starts from each rest
/// at the recorded place, gets the recorded efforts on this joint, and its other joints are held
/// where they were by a PID.
///
/// Before each ramp the model creeps, heavily damped, until it rests under the effort under which
/// the recorded joint rests, so that friction with a memory starts in the state that the recording
/// shows; the way that it creeps is taken off simulated_q. A jump of the recorded position (a new
/// start) ends a ramp without an event. A ramp starts low: rests whose effort was above 60 % of
/// that at the onset are pauses. Rests pushed against an end of the range are left out.
/// @throws InvalidInput  sizes that do not fit, or no such joint.
Breakaway breakaway(Engine& engine, const Model& arm, const ReplayInput& input,
                    const BreakawayOptions& options);

}  // namespace veridyn
