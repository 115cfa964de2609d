#pragma once

#include <string>
#include <vector>

#include "veridyn/dynamics/regressor_batch.hpp"
#include "veridyn/effects/effect.hpp"

namespace veridyn {

/// A motion of an arm whose bodies have values, and what the arm's own values ask for along it.
struct ChannelMotion {
  const Model& arm;
  const RegressorBatch& bodies;  ///< Bodies of the arm
  const VectorXd& phi;           ///< inertial parameters of all bodies
  const MatrixXd& q;             ///< (rows x n) [rad] or [m]
  const MatrixXd& dq;
  const MatrixXd& ddq;
  const MatrixXd& effort;  ///< (rows x n) bodies and effects together [N m] or [N]
  double dt;               ///< [s] between rows
};

/// A column that is a torque of the arm's bodies: what an excitation can plan for.
struct RigidColumn {
  Eigen::Vector3d gravity;  ///< [m/s^2] in place of the arm's own
  bool at_rest;             ///< true: velocities and accelerations count as zero
  VectorXd joints;          ///< (n) nonzero where the joint's row counts
};

/// In place of a joint: the same error on all of them.
constexpr int kAllJoints = -1;

/// A key under which a channel error is injected into a simulation.
struct InjectedValue {
  std::string key;   ///< "gain"
  double initial;    ///< Value where the request gives none
  double zero;       ///< no error at all; parameter = value - zero
  bool nonnegative;  ///< true: a value below `zero` cannot be
};

/// An error that is no force along an axis: either of a sensor (SensorError) or of the arm as a
/// whole (ArmEffect); derive from one of these. Its columns are derivatives of the torque that the
/// arm's own values ask for, so they are right to first order and only for an arm with values.
class ChannelEffect : public Effect {
 public:
  /// True if it concerns the arm as a whole and needs no joint.
  virtual bool whole_arm() const = 0;

  /// True if the same error on all joints is one cause: one clock, one amplifier.
  virtual bool can_be_common() const { return false; }

  /// True if a diagnosis asks about it of itself; false: only where it is named, since it explains
  /// too much of whatever else is wrong.
  virtual bool asked_unnamed() const { return true; }

  /// True if joint i's torque has columns of it; `joint` is the one whose channel has the error, or
  /// kAllJoints where all have the same one (can_be_common()).
  virtual bool acts_on(int i, int joint) const = 0;

  /// Torque per unit of every parameter, (rows x n) each; columns of joints that it does not act on
  /// are not read.
  virtual std::vector<MatrixXd> columns(const ChannelMotion& motion, int joint) const = 0;

  /// True if the columns are torques of the arm's bodies; an excitation can plan for such only.
  virtual bool has_rigid_columns() const { return false; }

  /// They are; empty where the arm has no such column (no gravity).
  virtual std::vector<RigidColumn> rigid_columns(const Model& arm, int joint) const;

  /// Puts the error into an arm; `joint` may be kAllJoints.
  virtual void apply(ModelDescription& arm, int joint, const std::vector<double>& values) const = 0;

  /// One for each of parameters().
  virtual std::vector<InjectedValue> injected(JointType type) const = 0;

  /// Place in a parameter's name: "yaw", or "arm" for the whole arm.
  std::string place(const Model& arm, const EffectTerm& term) const;
};

/// What a sensor of a joint shows of what is so: a gain, a delay, a wrong zero. A model that knows
/// it stays right, and JointSensors takes it off every signal: of recordings, in control loops, on
/// boards. A simulated arm keeps it apart from its dynamics.
class SensorError : public ChannelEffect {
 public:
  bool whole_arm() const final { return false; }

  /// Puts the error into what the sensors of one joint show.
  virtual void change(RecordedChannel& shown, const std::vector<double>& values) const = 0;

  /// Puts it into the coordinates' `recorded`.
  void apply(ModelDescription& arm, int joint, const std::vector<double>& values) const final;

  /// True if it is a factor of the recorded torque alone.
  virtual bool scales_torque() const { return false; }

  /// True if it may begin while the arm moves, as a slipped encoder does; such are watched.
  virtual bool may_begin_suddenly() const { return false; }
};

/// What is wrong with the arm as a whole, or missing in it, and is part of its dynamics: how its
/// base stands. Any rows of the regressor may have columns of it.
class ArmEffect : public ChannelEffect {
 public:
  bool whole_arm() const final { return true; }
  EffectTraits traits(const ShapeValues& shape) const override;
  bool acts_on(int /*i*/, int /*joint*/) const override { return true; }

  /// Makes the arm one that has it, by facts that the model has anyway (its gravity) or by a term of
  /// its arm_effects, see term_of(). Predictions of such a term are its columns times its values.
  virtual void change(ModelDescription& arm, const std::vector<double>& values) const = 0;

  /// The arm with the states that the effect adds to its motion: passive coordinates behind the
  /// arm's own, which engines move without a motor. Without states: the arm as it is.
  virtual ModelDescription with_states(const ModelDescription& arm,
                                       const std::vector<double>& /*values*/) const {
    return arm;
  }

  void apply(ModelDescription& arm, int /*joint*/, const std::vector<double>& values) const final {
    change(arm, values);
  }

 protected:
  /// The effect's own entry among arm_effects, where it keeps values; a new one has zeros.
  EffectTerm& term_of(ModelDescription& arm) const;
};

/// The torques (rows x n) [N m], [N] of the model's arm_effects along a motion, columns times values;
/// empty (0 x 0) where it has none, or bodies without values.
MatrixXd arm_effect_torques(const Model& arm, const RegressorBatch& bodies, const MatrixXd& q,
                            const MatrixXd& dq, const MatrixXd& ddq, double dt);

/// The arm with all states of its arm_effects, see ArmEffect::with_states().
Model with_arm_states(const Model& arm);

/// The channel effect of that name, or nothing.
const ChannelEffect* channel_effect(const std::string& name);

/// All of them, in the order of CONTRACT.md; registered ones follow.
const std::vector<const ChannelEffect*>& channel_effects();

/// The joint whose channel a term is about; kAllJoints where its axis is zero and the error can be
/// common to all.
int channel_joint(const ChannelEffect& effect, const EffectTerm& term);

/// The arm with the error that `term` describes.
Model with_channel_error(const Model& arm, const EffectTerm& term,
                         const std::vector<double>& values);

}  // namespace veridyn
