#pragma once

namespace veridyn {

/// Kind of contribution that an effect makes.
enum class EffectRole {
  kInertia,   ///< torque per acceleration: part of the mass matrix
  kFriction,  ///< opposes the motion along its axis
  kForce,     ///< any other torque along its axis
  kSensor,    ///< no torque: an error of a recorded signal, see SensorError
  kArm,       ///< no force along an axis: a fact about the whole arm, see ArmEffect
};

/// Form of friction at rest: a single force or a whole interval of forces.
enum class DryFriction {
  kNone,      ///< one force in every state
  kConstant,  ///< level * sign(ds), whatever the position, speed, load and time
  kVarying,   ///< the sign of ds times a level that depends on them
};

/// Properties that determine how other folders treat an effect. They belong to a class *and* its constants:
/// load-dependent friction remembers the path only if it has a distance. Tests compare each property with the
/// columns.
struct EffectTraits {
  EffectRole role = EffectRole::kForce;

  // Inputs of the columns: entries of AxisSample.
  bool uses_position = false;      ///< s
  bool uses_velocity = false;      ///< ds
  bool uses_acceleration = false;  ///< dds
  bool uses_source = false;        ///< from_s, from_ds: needs EffectTerm::from
  bool uses_load = false;          ///< load: needs the values of the bodies

  bool memory = false;  ///< a row depends on earlier rows
  DryFriction dry = DryFriction::kNone;
  bool affine = false;  ///< torque = constant + a s + b ds + c dds, at all times

  /// The torque depends on the position of the joint. Reports plot such an effect over the position.
  bool depends_on_position = false;
  bool depends_on_time = false;  ///< time since the start of the recording
  /// A wrong constant of the robot file has exactly the same columns: recordings cannot separate the two.
  bool same_as_wrong_constant = false;
  bool slow = false;           ///< its torque is visible at low speed and after reversals
  bool holds_at_rest = false;  ///< exerts a force on a joint at rest, like a spring or a cable
  bool lasting = false;        ///< constant from day to day; friction and offsets are not
  /// Present in every joint and different from day to day: friction level, damping, offset.
  bool elementary = false;
  bool tabulated = false;   ///< a measured curve without a known cause
  bool mixed_axes = false;  ///< plausible along a combination of coordinates (a tendon, a wrist)
  /// False: describes measured motion to first order, and would be unstable as a force in a forward simulation.
  bool forward_simulable = true;
  /// Reason, as printed after "transmission_compliance on yaw: "; empty if it can be simulated.
  const char* not_simulable_because = "";
  /// Attribute of a simulator's joint that holds it: "damping", "friction", "armature", "stiffness" or "offset".
  const char* urdf_attribute = "";
};

/// True if the effect can act on an arm at rest; dry friction only if it is known from which side the arm came to rest.
inline bool acts_at_rest(const EffectTraits& t, bool approached) {
  const bool dry = t.dry == DryFriction::kConstant && approached;
  return !t.memory && !t.depends_on_time && !t.uses_acceleration && (!t.uses_velocity || dry);
}

}  // namespace veridyn
