#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "veridyn/math/types.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn {

/// Relation between measured and true signals of an arm's joints, as far as its model contains it
/// (`recorded:` of a coordinate in an identified model, which `diagnose --model-out` writes):
///
///   measured q   = q + position_offset                  [rad], [m]; velocities have no error
///   measured tau = torque_gain * C d,  d = tau(t - torque_delay)  [N m], [N]
///
/// where C has ones on its diagonal and the crosstalk between the joints' torque channels beside it.
///
/// All corrections of such errors happen in this class. **All other classes expect true
/// coordinates**: poses, dynamics, ArmState, GravityCompensation, references, limits of the robot
/// file. A control loop converts twice, on reading and on writing:
///
///   JointSensors sensors(arm);
///   every cycle:
///     sensors.correct_positions(q);  // as the encoders show them -> true
///     state.update(q, dq);
///     tau = control.update(state, wanted);  // `wanted` is true, too: see add_position_errors()
///     sensors.add_torque_errors(tau);  // as the drives count them, if they share the recorded scale
///
/// A delay is corrected in recordings only, where later samples are available (torque_at()). A loop
/// cannot correct it: the torque that is measured now is that of torque_delay() seconds ago and
/// must be compared with the model's torque of that instant.
///
/// Functions allocate only where their comment says so; const functions may be called from several
/// threads.
class JointSensors {
 public:
  /// A vector that is changed in place, one entry for each joint.
  using InPlace = Eigen::Ref<VectorXd>;

  /// Uses the sensor errors of the model.
  explicit JointSensors(const Model& arm);

  /// Uses these sensor errors; currents are treated as torques.
  explicit JointSensors(std::vector<RecordedChannel> channels);

  int joints() const { return static_cast<int>(channels_.size()); }

  /// True if the model knows no sensor errors: all functions then leave their vectors unchanged.
  bool ideal() const { return ideal_; }

  /// Turns measured positions into true ones, and true positions into those that the encoders would
  /// read, such as set points of a robot that counts in encoder coordinates.
  void correct_positions(InPlace q) const noexcept { q -= offset_; }
  void add_position_errors(InPlace q) const noexcept { q += offset_; }

  /// Turns measured torques into true ones. It also turns true torques into the commands for which a drive
  /// produces them, if commands and recordings share one scale, as on dVRK boards, where both are motor
  /// currents. They do not share it if torque sensors measure the torque: then remove `torque_gain` and
  /// `torque_crosstalk` from `recorded:` in the model. Once corrected scales are in the drives' configuration
  /// (`export --dvrk-scales`), remove `torque_gain`.
  void correct_torques(InPlace tau) const noexcept {
    tau.array() /= gain_.array();
    remove_crosstalk(tau);
  }
  void add_torque_errors(InPlace tau) const noexcept {
    add_crosstalk(tau);
    tau.array() *= gain_.array();
  }

  /// Largest true torques for which no command exceeds `largest` [N m], [N], both (n), whatever their
  /// signs. Joints whose crosstalk would make one exceed it are limited in the same ratio. Allocates.
  VectorXd largest_true_torques(const VectorRef& largest) const;

  /// Turns measured motor currents [A] into true torques by the model's drive gains. See
  /// require_drive_gains().
  void correct_currents(InPlace current) const noexcept {
    current.array() *= drive_gain_.array() / gain_.array();
    remove_crosstalk(current);
  }

  /// @throws InvalidInput  a coordinate has no drive gain. @param where  begins the message.
  void require_drive_gains(const Model& arm, const std::string& where) const;

  /// Delay [s] of the measured torque of a joint.
  double torque_delay(JointIndex joint) const { return delay_[joint.value]; }

  /// The torque of sample `k` corrected for torque_delay(), from samples 0 .. count - 1 that were
  /// recorded `dt` seconds apart: linear interpolation, and the nearest sample at the ends. @param
  /// recorded  a callable: sample number -> recorded torque.
  template <typename Recorded>
  double torque_at(JointIndex joint, Eigen::Index k, Eigen::Index count, double dt,
                   const Recorded& recorded) const {
    const double at = std::clamp(static_cast<double>(k) + delay_[joint.value] / dt, 0.0,
                                 static_cast<double>(count - 1));
    const auto low = std::max<Eigen::Index>(
        0, std::min<Eigen::Index>(static_cast<Eigen::Index>(at), count - 2));
    const double share = at - static_cast<double>(low);
    return share == 0.0 ? recorded(low)
                        : recorded(low) + share * (recorded(low + 1) - recorded(low));
  }

  /// Turns a true motion and its torques into the recorded ones, (rows x n) each, delay included;
  /// torques before the first row are taken equal to the first. Allocates.
  /// @param time  (rows) [s], rising.
  void add_errors(const VectorRef& time, MatrixXd& q, MatrixXd& tau) const;

  /// A sentence for every error: "the encoder of joint 'pitch' shows 0.1 rad more than there is".
  std::vector<std::string> descriptions(const Model& arm) const;

 private:
  void remove_crosstalk(InPlace tau) const noexcept;
  void add_crosstalk(InPlace tau) const noexcept;

  std::vector<RecordedChannel> channels_;
  MatrixXd crosstalk_;  // LU factors of C in one matrix (L has a unit diagonal); empty without crosstalk
  VectorXd offset_, gain_, delay_, drive_gain_;
  bool ideal_ = true;
};

}  // namespace veridyn
