#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "veridyn/math/types.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn {

/// What the sensors of an arm's joints show and what is so, as far as its model knows the
/// difference (`recorded:` of a coordinate in a MODEL, which `diagnose --model-out` writes):
///
///   measured q   = q + position_offset                  [rad], [m]; velocities have no error
///   measured tau = torque_gain * tau(t - torque_delay)  [N m], [N]
///
/// This is the only place that takes such errors off a signal or puts them on. **All other classes
/// mean true coordinates**: poses, dynamics, ArmState, GravityCompensation, references, limits of
/// the robot file. A control loop crosses over twice, on reading and on writing:
///
///   JointSensors sensors(arm);
///   every cycle:
///     sensors.correct_positions(q);  // as the encoders show them -> true
///     state.update(q, dq);
///     tau = control.update(state, wanted);  // `wanted` is true, too: see show_positions()
///     sensors.show_torques(tau);  // as the drives count them, if they share the recorded scale
///
/// A delay is undone in recordings only, where later samples are there (torque_at()). A loop cannot
/// undo it: a measured torque that arrives now is the one of torque_delay() seconds ago, and whoever
/// compares it with a model compares it with the model's torque of that instant.
///
/// Nothing allocates after the constructor but what says so; const functions serve many threads.
class JointSensors {
 public:
  /// A vector that is changed in place, one entry for each joint.
  using InPlace = Eigen::Ref<VectorXd>;

  /// As the model knows them.
  explicit JointSensors(const Model& arm);

  /// With these errors; currents count as torques.
  explicit JointSensors(std::vector<RecordedChannel> channels);

  int joints() const { return static_cast<int>(channels_.size()); }

  /// True if everything is shown as it is: all functions leave their vectors as they are.
  bool ideal() const { return ideal_; }

  /// Measured positions become true ones, and true ones what the encoders show of them: set points
  /// for a robot that counts in encoder coordinates.
  void correct_positions(InPlace q) const noexcept { q -= offset_; }
  void show_positions(InPlace q) const noexcept { q += offset_; }

  /// Measured torques become true ones, and true ones what is recorded of them. The latter is also
  /// the command that makes a drive give `tau`, where commands have the scale of the recorded
  /// torques: both through the motor's current, as on dVRK boards. It is not where torques are
  /// measured by sensors of their own, nor once corrected scales stand in the drives' configuration
  /// (`export --dvrk-scales`): then `recorded: torque_gain` must go from the model.
  void correct_torques(InPlace tau) const noexcept { tau.array() /= gain_.array(); }
  void show_torques(InPlace tau) const noexcept { tau.array() *= gain_.array(); }

  /// Measured motor currents [A] become true torques, by the model's drive gains. See
  /// require_drive_gains().
  void correct_currents(InPlace current) const noexcept {
    current.array() *= drive_gain_.array() / gain_.array();
  }

  /// @throws InvalidInput  a coordinate has no drive gain. @param where  begins the message.
  void require_drive_gains(const Model& arm, const std::string& where) const;

  /// [s] by which the measured torque of a joint is late.
  double torque_delay(int joint) const { return delay_[joint]; }

  /// The torque of sample `k` out of samples 0 .. count - 1 that were recorded `dt` seconds apart:
  /// what was recorded torque_delay() later, by a straight line; the nearest that is there at the
  /// ends. @param recorded  a callable: sample number -> recorded torque.
  template <typename Recorded>
  double torque_at(int joint, Eigen::Index k, Eigen::Index count, double dt,
                   const Recorded& recorded) const {
    const double at = std::clamp(static_cast<double>(k) + delay_[joint] / dt, 0.0,
                                 static_cast<double>(count - 1));
    const auto low = std::max<Eigen::Index>(
        0, std::min<Eigen::Index>(static_cast<Eigen::Index>(at), count - 2));
    const double share = at - static_cast<double>(low);
    return share == 0.0 ? recorded(low)
                        : recorded(low) + share * (recorded(low + 1) - recorded(low));
  }

  /// What is recorded of a true motion and its torques, (rows x n) each, delay included; before the
  /// first row torques were those of the first. Allocates.
  /// @param time  (rows) [s], rising.
  void show(const VectorXd& time, MatrixXd& q, MatrixXd& tau) const;

  /// A sentence for every error: "the encoder of joint 'pitch' shows 0.1 rad more than there is".
  std::vector<std::string> in_words(const Model& arm) const;

 private:
  std::vector<RecordedChannel> channels_;
  VectorXd offset_, gain_, delay_, drive_gain_;
  bool ideal_ = true;
};

}  // namespace veridyn
