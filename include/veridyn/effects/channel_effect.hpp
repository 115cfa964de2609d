#pragma once

#include <optional>
#include <string>
#include <vector>

#include "veridyn/dynamics/torque_regressor.hpp"
#include "veridyn/effects/cause.hpp"
#include "veridyn/effects/effect.hpp"

namespace veridyn {

/// A motion of an arm whose bodies have values, and the torques of these values along it.
struct ChannelMotion {
  const Model& arm;
  const TorqueRegressor& bodies;  ///< the arm's bodies
  const VectorXd& phi;           ///< inertial parameters of all bodies
  const MatrixXd& q;             ///< (rows x n) [rad] or [m]
  const MatrixXd& dq;
  const MatrixXd& ddq;
  const MatrixXd& effort;  ///< (rows x n) bodies and effects together [N m] or [N]
  double dt;               ///< [s] between rows
  std::optional<JointIndex> from{};  ///< the other joint, of an error that uses a source (EffectTraits)
};

/// A column that is a torque of the arm's bodies, so that an excitation can be designed for it.
struct RigidColumn {
  Eigen::Vector3d gravity;  ///< [m/s^2] replaces the arm's gravity
  bool at_rest;             ///< true: velocities and accelerations are taken as zero
  VectorXd joints;          ///< (n) nonzero for joints whose rows count
};

/// A key under which a channel error is injected into a simulation.
struct InjectedValue {
  std::string key;   ///< "gain"
  double initial;    ///< value if the request has none
  double zero;       ///< value without any error; parameter = value - zero
  bool nonnegative;  ///< true: values below `zero` are refused
};

/// An error that is not a force along an axis: either of a sensor (SensorError) or of the arm as a
/// whole (ArmEffect); derive from one of these. Its columns are derivatives of the torque that the
/// arm's values predict, so they hold to first order and only for an arm with values.
class ChannelEffect : public Effect {
 public:
  /// True if it concerns the whole arm and belongs to no joint.
  virtual bool whole_arm() const = 0;

  /// True if one cause may put the same error on all joints, such as a common clock or amplifier.
  virtual bool can_be_common() const { return false; }

  /// True if the torque of joint i depends on it; `joint` is the one whose channel has the error, nullopt if
  /// all have the same one (can_be_common()).
  virtual bool acts_on(int i, std::optional<JointIndex> joint) const = 0;

  /// Torque per unit of every parameter, (rows x n) each; columns of joints for which acts_on() is
  /// false are not read.
  virtual std::vector<MatrixXd> columns(const ChannelMotion& motion, std::optional<JointIndex> joint) const = 0;

  /// True if the columns are torques of the arm's bodies. An excitation can be designed only for
  /// effects with such columns.
  virtual bool has_rigid_columns() const { return false; }

  /// Columns as torques of the bodies; empty if they vanish for this arm, for example without gravity.
  virtual std::vector<RigidColumn> rigid_columns(const Model& arm, std::optional<JointIndex> joint) const;

  /// Adds the error to an arm. @param joint  nullopt: all joints. @param from  the other joint of an error
  /// with a source.
  virtual void apply(ModelDescription& arm, std::optional<JointIndex> joint, std::optional<JointIndex> from,
                     const std::vector<double>& values) const = 0;

  /// Keys for injection, one for each of parameters().
  virtual std::vector<InjectedValue> injected(JointType type) const = 0;

  /// Name of the joint that a parameter of the term belongs to: "yaw", or "arm" for the whole arm.
  std::string place(const Model& arm, const EffectTerm& term) const;
};

/// An error between a true signal and what the sensor of a joint measures: gain, delay, wrong zero.
/// It leaves the dynamics as they are; JointSensors removes it from recordings, in control loops
/// and on boards. A simulation applies it after the dynamics.
class SensorError : public ChannelEffect {
 public:
  bool whole_arm() const final { return false; }

  /// Adds the error to the channel of one joint. @param from  the other joint of an error that uses
  /// a source.
  virtual void add_to_channel(RecordedChannel& shown, std::optional<JointIndex> from,
                              const std::vector<double>& values) const = 0;

  /// Adds the error to `recorded` of the coordinates that it concerns.
  void apply(ModelDescription& arm, std::optional<JointIndex> joint, std::optional<JointIndex> from,
             const std::vector<double>& values) const final;

  /// True if it is a factor on the recorded torque and nothing else.
  virtual bool scales_torque() const { return false; }

  /// True if it may begin while the arm moves, for example when an encoder slips. Watch tests such errors only.
  virtual bool may_begin_suddenly() const { return false; }
};

/// A property of the whole arm that is part of its dynamics, such as the mounting of its base. Any row of the
/// regressor may depend on it.
class ArmEffect : public ChannelEffect {
 public:
  bool whole_arm() const final { return true; }
  EffectTraits traits(const ShapeValues& shape) const override;
  bool acts_on(int /*i*/, std::optional<JointIndex> /*joint*/) const override { return true; }

  /// Gives the arm this property, either through a property that every model has (its gravity) or as a term
  /// among its arm_effects, see term_of(). Such a term contributes its columns times its values.
  virtual void change(ModelDescription& arm, const std::vector<double>& values) const = 0;

  /// Further starting points of the iteration, for effects that the linearisation at zero does not describe.
  virtual std::vector<std::vector<double>> further_start_values() const { return {}; }

  /// The values that change one arm into the other. @param sum  sum of all successive changes, which is the
  /// default result; override the function if changes do not add.
  virtual std::vector<double> values_between(const ModelDescription& /*without*/, const ModelDescription& /*with*/,
                                             std::vector<double> sum) const {
    return sum;
  }

  /// The arm with the states that the effect adds to its motion: passive coordinates after the
  /// arm's own, without a motor. An effect without states returns the arm unchanged.
  virtual ModelDescription with_states(const ModelDescription& arm,
                                       const std::vector<double>& /*values*/) const {
    return arm;
  }

  void apply(ModelDescription& arm, std::optional<JointIndex> /*joint*/, std::optional<JointIndex> /*from*/,
             const std::vector<double>& values) const final {
    change(arm, values);
  }

 protected:
  /// The effect's own entry among arm_effects; creates one with zeros if there is none.
  EffectTerm& term_of(ModelDescription& arm) const;
};

/// Torques (rows x n) [N m], [N] of the model's arm_effects along a motion, columns times values;
/// empty (0 x 0) without such effects or if a body has no values.
MatrixXd arm_effect_torques(const Model& arm, const TorqueRegressor& bodies, const MatrixXd& q,
                            const MatrixXd& dq, const MatrixXd& ddq, double dt);

/// The arm with the states of all its arm_effects, see ArmEffect::with_states().
Model with_arm_states(const Model& arm);

/// The channel effect of that name, or nullptr.
const ChannelEffect* channel_effect(const std::string& name);

/// All channel effects in the order of docs/contract.md; registered ones follow.
const std::vector<const ChannelEffect*>& channel_effects();

/// The joint whose channel the term concerns; nullopt if its axis is zero and the error can be common to all.
std::optional<JointIndex> channel_joint(const ChannelEffect& effect, const EffectTerm& term);

/// The joint from which an error comes; nullopt: it has no source.
std::optional<JointIndex> channel_source(const EffectTerm& term);

/// The arm with the error that `term` describes. @throws InvalidInput  it is no channel error.
Model with_channel_error(const Model& arm, const EffectTerm& term,
                         const std::vector<double>& values);

}  // namespace veridyn
