#pragma once

namespace veridyn {

/// What an effect is to those who use it.
enum class EffectRole {
  kInertia,   ///< torque per acceleration: part of the mass matrix
  kFriction,  ///< opposes the motion along its axis
  kForce,     ///< any other torque along its axis
  kSensor,    ///< no torque: an error of a recorded signal, see SensorError
  kArm,       ///< no force along an axis: a fact about the whole arm, see ArmEffect
};

/// When a diagnosis asks about an effect. Errors of the measurement come first, because every other
/// effect would be fitted to them; friction comes last, because it can imitate the others.
enum class DiagnosisStage { kChannel = 0, kInertia = 1, kFriction = 2 };

/// Whether friction at rest is one force or a whole interval of forces.
enum class DryFriction {
  kNone,      ///< one force in every state
  kConstant,  ///< level * sign(ds), whatever the position, speed, load and time
  kVarying,   ///< the sign of ds times a level that depends on them
};

/// Everything that other rooms must know about an effect to treat it rightly. Traits are facts
/// about a class *and* its constants: load-dependent friction remembers the path only where it is
/// given a distance. Tests compare each of them with what the columns do.
struct EffectTraits {
  EffectRole role = EffectRole::kForce;
  DiagnosisStage stage = DiagnosisStage::kFriction;

  // What the columns are computed from: the entries of AxisSample.
  bool uses_position = false;      ///< s
  bool uses_velocity = false;      ///< ds
  bool uses_acceleration = false;  ///< dds
  bool uses_source = false;        ///< from_s, from_ds: needs EffectTerm::from
  bool uses_load = false;          ///< load: needs the values of the bodies

  bool memory = false;  ///< a row depends on the rows before it
  DryFriction dry = DryFriction::kNone;
  bool affine = false;  ///< torque = constant + a s + b ds + c dds, at all times

  bool depends_on_position = false;  ///< one motion, which ties all positions, may mislead about it
  bool depends_on_time = false;      ///< counted from the start of the recording
  /// A wrong constant of the robot file does exactly the same, and data cannot tell which it is.
  bool same_as_wrong_constant = false;
  bool slow = false;           ///< seen at low speed and after reversals
  bool holds_at_rest = false;  ///< moves a joint at rest, like a spring or a cable
  bool lasting = false;        ///< the same on every day; friction and offsets are not
  bool elementary = false;     ///< in every joint, different every day: level, damping, zero
  bool tabulated = false;      ///< a measured curve and no cause: it has no name
  bool mixed_axes = false;     ///< plausible along a combination of coordinates (a tendon, a wrist)
  /// False: describes measured motion to first order, and would be unstable as a force in a forward
  /// simulation.
  bool forward_simulable = true;
  /// Why not, to stand after "transmission_compliance on yaw: "; empty where it can be simulated.
  const char* not_simulable_because = "";
  /// The attribute of URDF's element `dynamics` that says the same: "damping" or "friction"; empty: none.
  const char* urdf_attribute = "";
};

}  // namespace veridyn
