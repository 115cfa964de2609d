#pragma once

#include <string>
#include <vector>

#include "veridyn/identification/identification.hpp"

namespace veridyn {

/// Share of a joint's range and speed below which its motion identifies neither friction nor inertia.
constexpr double kHardlyMovingShare = 0.05;

/// Quality of an identification for one joint.
enum class IdentifiedState {
  kAtFloor,      ///< the residual is little above the noise floor
  kUnexplained,  ///< the residual is far above the floor: the model is incomplete
  kHardlyMoved,  ///< the joint hardly moves in the recordings
  kNoTorque,     ///< the joint's torque is always zero: it was not recorded, or the joint was not driven
  kCannotTell,   ///< the motion does not repeat, so that the noise floor is unknown, the joint hardly moves in the test, or
                 ///< a constant torque leaves hardly more
};
/// "at_floor", "unexplained", "hardly_moved", "no_torque", "cannot_tell".
const char* name_of(IdentifiedState state);

struct IdentifiedJoint {
  std::string joint;
  IdentifiedState state = IdentifiedState::kCannotTell;
  double error = 0.0;  ///< relative error on held-out recordings if there are any, else on the training recordings
  double floor = 0.0;  ///< relative noise floor; NaN if nothing repeats
  double constant = 0.0;  ///< relative error of a constant torque in the training recordings; infinite if none was fitted
  /// Share of the joint's range covered by the training; NaN: no limits in the file.
  double range = 0.0;
  double speed = 0.0;  ///< largest share of the speed limit; NaN: no limit
};

/// Quality of an identification joint by joint, with the recommended next step.
struct IdentificationVerdict {
  std::vector<IdentifiedJoint> joints;
  bool held_out = false;  ///< errors are those of held-out recordings, of which no row is in the training
  std::string sentence;   ///< joints by state, with the recommendation
};

/// "noise floor", or "repetitions differ by" if the repetitions of the motion differ by more than the error of the model.
const char* noise_floor_label(const Identification& id);

/// @param id  result with a model.
IdentificationVerdict verdict_of(const Identification& id);

}  // namespace veridyn
