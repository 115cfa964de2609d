// effects/: everything beyond rigid bodies, one file per effect; sensor errors, and the text form of a cause.
#pragma once

#include <array>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "veridyn/effects/effect_traits.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn {

/// Speed below which friction without memory passes linearly through zero instead of switching its sign.
constexpr double kRestSpeed = 1e-4;  ///< [rad/s] or [m/s]

/// One sample along an effect's axis s = c . q + s0.
struct AxisSample {
  double time = 0.0;    ///< [s] time since the recording or the run began
  double s = 0.0;       ///< [rad] or [m]
  double ds = 0.0;      ///< [rad/s] or [m/s]
  double dds = 0.0;     ///< [rad/s^2] or [m/s^2]
  double from_s = 0.0;  ///< [rad] or [m] position of the other coordinate, for couplings
  double from_ds = 0.0;
  double load = 0.0;  ///< torque or force of the rigid bodies along the axis [N m] or [N]
};

/// Physically possible sign of a parameter.
enum class ParameterSign { kAny, kNonnegative };

/// Unit placeholder of couplings: "rad" or "m", whichever the other coordinate has.
constexpr const char* kSourceUnit = "(source unit)";

/// A parameter in which the torque is linear.
struct EffectParameter {
  std::string name;
  std::string unit_revolute;
  std::string unit_prismatic;
  ParameterSign sign = ParameterSign::kAny;
  /// Largest magnitude for which the columns are valid; a diagnosis rejects larger estimates.
  double largest_revolute = 1e300;
  double largest_prismatic = 1e300;
};

/// Unit of the initial values in the grid of a shape constant.
enum class ShapeScale {
  kByUnit,    ///< shares of travel for "rad", of speed for "rad/s", else spread over the range
  kAbsolute,  ///< values as they are
  kTravel,    ///< shares of the axis' travel
  kSpeed,     ///< shares of its largest speed
  kDuration,  ///< shares of the longest recording
  kMiddle,    ///< the middle of the axis' travel
  kWaves,     ///< a wave number, proposed by a spectrum over the position
};

/// A constant that shapes the columns and in which the torque is not linear.
struct EffectShape {
  std::string name;
  std::string unit_revolute;
  std::string unit_prismatic;
  double initial = 0.0;  ///< value if the file has none
  double lower = 0.0;    ///< range of the search
  double upper = 0.0;
  bool logarithmic = true;  ///< search in the logarithm; a value from the file must be positive
  bool searched = true;     ///< false: taken from the file or the caller and never searched
  /// Initial value along prismatic axes, if different; 0: the same.
  double initial_prismatic = 0.0;
  ShapeScale scale = ShapeScale::kByUnit;  ///< unit of the entries of `grid`
  /// Initial values of a search. Empty: three of kByUnit for a searched constant; a constant that
  /// is not searched keeps its value.
  std::vector<double> grid{};

  /// `initial` or `initial_prismatic`.
  double initial_value(JointType type) const;
};

/// How an axis moves, in recordings or within its limits.
struct AxisMotion {
  JointType type = JointType::kRevolute;
  double middle = 0.0;    ///< middle of its travel [rad] or [m]
  double travel = 0.0;    ///< travel [rad] or [m]
  double speed = 0.0;     ///< largest speed [rad/s] or [m/s]
  double duration = 0.0;  ///< [s] duration of the longest recording; 0: unknown
  /// Wave numbers of significant peaks of a spectrum; may be empty. Nullopt: no spectrum was computed.
  std::optional<std::vector<double>> waves{};
};

/// A range of the axis' motion, or of that of `from`, outside of which an effect's columns are constant.
struct ActiveRange {
  bool of_source = false;
  bool of_velocity = false;  ///< true: a range of velocity; false: of position
  double low = 0.0, high = 0.0;
};

/// Values of shape constants, by name.
using ShapeChoice = std::map<std::string, double>;

constexpr int kMaxEffectShapes = 6;
constexpr int kMaxEffectParameters = 12;
constexpr int kMaxEffectStates = 8;

using ShapeValues = std::array<double, kMaxEffectShapes>;
using EffectState = std::array<double, kMaxEffectStates>;
using EffectColumns = std::array<double, kMaxEffectParameters>;

/// One physical cause of torque in addition to the rigid bodies, with all its properties. An effect is one
/// class in one file: identification, diagnosis, excitation, simulation and control use this interface and do
/// not depend on its name. See docs/adding-an-effect.md.
class Effect {
 public:
  virtual ~Effect() = default;

  /// The name in robot files, on the command line and in findings.
  virtual std::string name() const = 0;

  virtual std::vector<EffectParameter> parameters() const = 0;
  virtual std::vector<EffectShape> shapes() const { return {}; }

  /// Properties of the effect with these constants.
  virtual EffectTraits traits(const ShapeValues& shape) const = 0;

  /// Properties with the initial constants.
  EffectTraits traits() const;

  /// Initial values of the shape constants for an axis with this motion: all combinations of the constants' own
  /// grids. One empty choice if the effect has no searched constant; none if the spectrum has no significant wave.
  virtual std::vector<ShapeChoice> grid(const AxisMotion& motion) const;

  /// Ranges that a motion must reach for the columns to be independent; empty: any motion.
  virtual std::vector<ActiveRange> active_ranges(const ShapeValues& /*shape*/) const { return {}; }

  /// True if it can imitate many other causes: a diagnosis tests it after all others, unless the user names it.
  virtual bool imitates_others() const { return false; }

  /// Description of the identified effect for a technician, as printed after "Joint 3 has": "0.50 N
  /// of friction with memory: after a reversal it builds up over 0.14 mm".
  ///
  /// @param values  one for each of parameters().
  /// @param type    kPrismatic for newtons and metres, anything else for newton metres and radians.
  virtual std::string phrase(const std::vector<double>& values, const ShapeValues& shape,
                             JointType type) const = 0;
};

/// An effect that acts along an axis:
///
///   tau += c * (columns(sample) . parameters)
///
/// The sign convention is that of the motor's torque: friction is positive in the direction of
/// motion (seed errata on thesis 4.10 to 4.16). The same columns are the regressor of
/// identification, the force of simulation and the compensation of control, one sample at a time;
/// an effect with memory keeps it in the state.
class AxisEffect : public Effect {
 public:
  /// Computes one row of columns, parameters().size() entries; a state of zeros is the initial one.
  /// Changes the state only where traits(shape).memory is true. Never throws or allocates.
  virtual void columns(const AxisSample& sample, const ShapeValues& shape, EffectState& state,
                       EffectColumns& row) const noexcept = 0;
};

/// The effect of that name. @throws InvalidInput  no effect has it.
const Effect& find_effect(const std::string& name);

/// Like find_effect(), restricted to effects along an axis.
const AxisEffect& find_axis_effect(const std::string& name);

/// True for names that find_effect() or find_axis_effect() knows.
bool has_effect(const std::string& name);
bool has_axis_effect(const std::string& name);

/// All effects, and those that act along an axis, in the order of docs/contract.md; registered ones follow.
const std::vector<const Effect*>& all_effects();
const std::vector<const AxisEffect*>& axis_effects();

/// Registers a user's effect: from then on robot files may contain it, and every command and class treats it
/// like a built-in one. Call it before models are read, from one thread.
///
/// @returns the effect, which lives as long as the program.
/// @throws InvalidInput  the name is taken, too many parameters or constants, or a constant whose
///                       range is empty.
const Effect& register_effect(std::unique_ptr<const Effect> effect);

/// An effect of a model prepared for loops: shape constants looked up, axis copied, state owned.
class BoundEffect {
 public:
  /// @throws InvalidInput  unknown effect, a key in the file that the effect does not have, a number that is
  /// not finite, a shape constant that must be positive and is not, or a coupling without `from`.
  BoundEffect(const Model& arm, const EffectTerm& term);

  const AxisEffect& effect() const { return *effect_; }
  const EffectTraits& traits() const { return traits_; }  ///< properties for the shape constants of this effect
  const EffectTerm& term() const { return term_; }
  int parameter_count() const { return static_cast<int>(parameters_.size()); }
  const std::vector<EffectParameter>& parameters() const { return parameters_; }

  /// Unit of parameter p on this axis.
  const std::string& unit(int p) const;

  /// Name of a parameter, such as "viscous_friction(yaw).coefficient"; axes of several joints read
  /// "(1.2178 yaw1 - 0.8306 pitch)". Shape constants that the file gives follow:
  /// "presliding_hysteresis(yaw, distance 0.005).level".
  std::string parameter_name(int p) const;

  /// Parameter values of the file, zero if it has none.
  const EffectColumns& values() const { return values_; }
  bool has_values() const { return has_values_; }

  /// Shape constants of the file, or else the effect's initial ones.
  const ShapeValues& shape() const { return shape_; }

  /// Effect::phrase() with the units of this axis and these constants.
  std::string phrase(const std::vector<double>& values) const;

  /// Clears the memory. @param start_time [s] origin of the time in sample().
  void reset(double start_time = 0.0) {
    state_ = {};
    start_time_ = start_time;
  }

  /// Computes s, ds, dds (and the source's) of one state; q, dq, ddq point at n entries `stride` apart.
  AxisSample sample(double time, const double* q, const double* dq, const double* ddq,
                    long stride) const noexcept;

  /// Computes one row of columns along the axis; advances the memory.
  void columns(const AxisSample& sample, EffectColumns& row) noexcept {
    effect_->columns(sample, shape_, state_, row);
  }

  /// The force along the axis with the values of the file; advances the memory.
  double force(const AxisSample& sample) noexcept;

  /// Torque per acceleration of an effect whose role is kInertia, with the values from the file.
  double inertia() const noexcept;

 private:
  const AxisEffect* effect_;
  EffectTraits traits_;
  EffectTerm term_;
  std::vector<EffectParameter> parameters_;
  std::string label_;  ///< text in parentheses in parameter_name()
  std::string source_unit_;
  JointType type_ = JointType::kRevolute;
  bool has_values_ = false;
  ShapeValues shape_{};
  EffectColumns values_{};
  EffectState state_{};
  double start_time_ = 0.0;
};

/// The linear form as text: "yaw" or "1.2178 yaw1 - 0.8306 pitch".
std::string axis_text(const Model& arm, const Axis& axis);

}  // namespace veridyn
