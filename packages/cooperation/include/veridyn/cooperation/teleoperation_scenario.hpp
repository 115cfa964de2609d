#pragma once

#include <string>
#include <vector>

#include "veridyn/control/teleoperation.hpp"
#include "veridyn/cooperation/scenario.hpp"

namespace veridyn {

/// Action of the operator in one phase of the scenario.
struct TeleoperationStep {
  Eigen::Vector3d way{0.0, 0.0, 0.0};  ///< [m] displacement of the hand, in the world
  double over = 1.0;                   ///< [s] duration of the motion
  bool clutch = true;                  ///< true if the clutch is engaged
};

/// A scenario with two arms in bilateral teleoperation. Its key `teleoperation`:
///
///   teleoperation:
///     leader: mtm
///     follower: psm
///     scale: 0.5
///     force_scale: 1
///     largest_force: 5
///     hand: {stiffness: 300, damping: 10}   # of an operator, for emulated arms
///     steps:                                # by the names of the phases
///       free: {hand: [0.04, 0, 0], over: 1}
///       back: {hand: [-0.04, 0, 0], over: 1, clutch: out}
///
/// Two arms, at most one wall, for the follower, and phases without commands. Keys that only a run of
/// members reads (`ask`, `faults`) are refused.
struct TeleoperationScenario {
  Scenario scenario;
  int leader = 0, follower = 1;
  TeleoperationOptions options;
  double hand_stiffness = 300.0, hand_damping = 10.0;  ///< [N/m], [N s/m] of the operator's hand
  std::vector<TeleoperationStep> steps;                ///< one for each phase
};

/// True if the file has a key `teleoperation`; false if it cannot be read, or is no YAML.
bool is_teleoperation(const std::string& path);

/// @throws InvalidInput  "file:line:column: found ..., expected ...".
TeleoperationScenario read_teleoperation(const std::string& path);

}  // namespace veridyn
