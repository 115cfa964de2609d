#pragma once

#include <string>
#include <vector>

#include "veridyn/simulation/replay.hpp"

namespace veridyn {

struct BreakawayOptions {
  JointIndex joint;
  double way = 0.0;  ///< [rad], [m] displacement that ends the joint's rest; 0: 10 mrad or 1 mm
  /// [rad/s], [m/s] speed above which the joint slides; 0: 50 mrad/s or 5 mm/s. Presliding friction allows
  /// creep of up to a millimetre before that.
  double speed = 0.0;
  double rest = 0.5;  ///< [s] required duration of the rest
};

/// One ramp: the joint rested, the effort rose, and the joint broke away.
struct BreakawayEvent {
  double rest_from = 0.0;  ///< [s] time since the recording began
  int direction = 0;       ///< direction of the motion: +1, -1
  double recorded_at = 0.0;
  double recorded = 0.0;  ///< [N m], [N] effort at the onset of sliding
  double simulated_at = 0.0;
  double simulated = 0.0;  ///< [N m], [N] the same in the simulation; NaN: the model did not slide
};

struct Breakaway {
  JointIndex joint;
  double speed = 0.0;  ///< [rad/s], [m/s] speed above which the joint slides
  std::vector<BreakawayEvent> events;
  /// Medians per direction, [N m], [N]; NaN without events.
  double recorded_forward = 0.0, recorded_backward = 0.0;
  double simulated_forward = 0.0, simulated_backward = 0.0;
  VectorXd simulated_q;  ///< (rows) simulated position of the joint; NaN where the model did not run

  /// Lists every ramp with both efforts, and the medians, as text.
  /// @param joint  the coordinate. @param recording  name of the recording in the text.
  std::string report(const Coordinate& joint, const std::string& recording) const;
};

/// Breakaway efforts of one joint in a recording of slow ramps, that is the efforts at which it
/// starts to slide, and those of a model under the same efforts: the model starts from each rest at
/// the recorded position, receives the recorded efforts on this joint, and a PID holds its other
/// joints at their recorded positions.
///
/// Before each ramp the model creeps, heavily damped, until it rests under the recorded effort, so
/// that presliding friction starts in the recorded state; this creep is subtracted from
/// simulated_q. A jump of the recorded position (a new start) ends a ramp without an event. Rests with an
/// effort above 60 % of the one at the onset are pauses within a ramp and start none. Rests against an end stop
/// are excluded.
/// @throws InvalidInput  sizes differ, or the joint does not exist.
Breakaway breakaway(Engine& engine, const Model& arm, const ReplayInput& input,
                    const BreakawayOptions& options);

}  // namespace veridyn
