#include "veridyn/control/safety_supervisor.hpp"

namespace veridyn {

const char* describe(SafetyState state) noexcept {
  switch (state) {
    case SafetyState::kDisabled:
      return "disabled";
    case SafetyState::kHoming:
      return "homing";
    case SafetyState::kReady:
      return "ready";
    case SafetyState::kActive:
      return "active";
    case SafetyState::kHolding:
      return "holding";
    case SafetyState::kFault:
      break;
  }
  return "fault";
}

const char* describe(SafetyFault fault) noexcept {
  switch (fault) {
    case SafetyFault::kNone:
      return "none";
    case SafetyFault::kNotFinite:
      return "a measurement that is NaN or infinite";
    case SafetyFault::kSensorAge:
      return "positions that are too old";
    case SafetyFault::kEncoderJump:
      return "a position that jumped";
    case SafetyFault::kController:
      return "a torque that is NaN or infinite";
    case SafetyFault::kOverrun:
      return "a cycle that took too long";
    case SafetyFault::kPosition:
      return "a position limit";
    case SafetyFault::kVelocity:
      return "a velocity limit";
    case SafetyFault::kTracking:
      return "a tracking error";
    case SafetyFault::kTorque:
      return "a saturated motor";
    case SafetyFault::kForce:
      return "a force limit";
    case SafetyFault::kNotHeld:
      return "an arm that does not come to rest";
    case SafetyFault::kForceSensor:
      break;
  }
  return "a force sensor that cannot be right";
}

}  // namespace veridyn
