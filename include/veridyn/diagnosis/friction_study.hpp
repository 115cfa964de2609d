#pragma once

#include <optional>
#include <string>
#include <vector>

#include "veridyn/diagnosis/diagnosis.hpp"
#include "veridyn/identification/friction_curve.hpp"

namespace veridyn {

/// Friction measured at one speed: the mean over all segments of nearly constant speed whose mean
/// speeds differ by less than a tenth.
struct FrictionAtSpeed {
  double velocity = 0.0;   ///< mean [rad/s], [m/s]
  double torque = 0.0;     ///< measured torque without that of bodies and offset [N m], [N]
  double deviation = 0.0;  ///< scatter of that torque within the segments
  double seconds = 0.0;    ///< total duration of the segments
  int runs = 0;
};

/// One breakaway: a joint at rest under a slowly increasing torque begins to slide.
struct FrictionBreakaway {
  std::string source;
  double time = 0.0;    ///< [s] since the recording began
  int direction = 0;    ///< +1, -1
  double torque = 0.0;  ///< as recorded, without that of bodies and offset [N m], [N]
};

enum class FrictionState {
  kConfirmed,     ///< it lowers the error of held-out rows
  kNotConfirmed,  ///< it was selected on the training rows and raises the error of held-out rows
  kNotSupported,  ///< it does not lower the error, or its value is impossible
  kCannotTell,    ///< the motion does not determine it
};
const char* name_of(FrictionState state);

/// The verdict on one kind of friction (an effect of the catalogue) on one joint.
struct FrictionVerdict {
  std::string effect;
  FrictionState state = FrictionState::kCannotTell;
  std::optional<double> p_value;
  std::vector<FoundParameter> parameters;  ///< empty unless it was found
  std::string words;                       ///< its size, or the reason against it
};

struct JointFrictionStudy {
  JointIndex joint;      ///< index in the robot
  std::string coordinate, unit, effort;  ///< "insertion", "m", "N"
  FrictionCurve curve;   ///< its joint index is that of the arm without the joints at rest
  std::vector<FrictionAtSpeed> speeds;
  std::vector<FrictionBreakaway> breakaways;
  std::vector<FrictionVerdict> verdicts;
  /// Relative errors on held-out rows: with viscous and Coulomb friction alone, and with all
  /// confirmed kinds of friction.
  double error_plain = 0.0, error = 0.0;
};

/// The result of study_friction() for all joints that move. Text, JSON and page show exactly this.
struct FrictionStudy {
  std::string robot;
  std::vector<std::string> resting;  ///< coordinates that are not studied
  std::vector<std::string> held_out; ///< recordings, or parts of them, on which the verdicts were validated
  std::vector<JointFrictionStudy> joints;
  Diagnosis diagnosis;    ///< of the arm without the joints at rest
  Identification fitted;  ///< the same arm with all confirmed effects, fitted to all rows; the curves are those of this fit
  std::string reason;     ///< reason for which there is no result; empty otherwise

  std::string report() const;
};

/// Measures friction against speed for every joint that moves, and decides which kinds of friction
/// the joint has.
///
/// Joints that travel less than 20 mrad or 2 mm in all recordings are fixed at their position
/// (with_fixed()); their errors and parameters do not count. Bodies keep the values of an identified model, and
/// are identified otherwise; friction and offsets are identified in either case. diagnose() tests
/// the kinds beyond viscous and Coulomb friction. Recordings in which the joint rests most of the
/// time give breakaways only.
///
/// @param test     held out; empty: the last recording, or the last third of a single one.
/// @param options  of the diagnosis; `effects` empty: all kinds of friction.
/// @throws InvalidInput  as diagnose().
FrictionStudy study_friction(const Model& arm, const Recordings& recordings,
                             const Recordings& test = {}, const DiagnosisOptions& options = {});

}  // namespace veridyn
