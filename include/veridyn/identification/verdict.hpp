#pragma once

#include <string>
#include <vector>

#include "veridyn/identification/identification.hpp"

namespace veridyn {

/// Of a joint's range and speed: what moves less shows friction at one place and inertia in the noise.
constexpr double kHardlyMoves = 0.05;

/// How good an identification is on one joint.
enum class IdentifiedState {
  kAtFloor,      ///< the model leaves little more than the noise
  kUnexplained,  ///< it leaves far more: the model lacks something
  kHardlyMoved,  ///< the recordings hardly move the joint: record it again
  kCannotTell,   ///< nothing repeats, so that the noise is not known
};
/// "at_floor", "unexplained", "hardly_moved", "cannot_tell".
const char* name_of(IdentifiedState state);

struct IdentifiedJoint {
  std::string joint;
  IdentifiedState state = IdentifiedState::kCannotTell;
  double error = 0.0;  ///< relative, held out where recordings were, else of training
  double floor = 0.0;  ///< relative noise floor; NaN where nothing repeats
  double range = 0.0;  ///< share of the range of the file that training moved over; NaN: no limits
  double speed = 0.0;  ///< largest share of the speed limit; NaN: no limit
};

/// What an identification is worth, joint by joint, and what to do next.
struct IdentificationVerdict {
  std::vector<IdentifiedJoint> joints;
  bool held_out = false;  ///< errors are of held-out recordings
  std::string sentence;   ///< joints by state, with what to do next
};

/// @param id  with a model.
IdentificationVerdict verdict_of(const Identification& id);

}  // namespace veridyn
