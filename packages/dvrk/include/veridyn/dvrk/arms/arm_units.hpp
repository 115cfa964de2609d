#pragma once

#include <cstdint>
#include <vector>

#include "veridyn/dvrk/protocol/encoder_words.hpp"
#include "veridyn/dvrk/config/io_config.hpp"
#include "veridyn/math/types.hpp"

namespace veridyn::dvrk {

/// Readings of the boards for one actuator.
struct RawActuator {
  EncoderWords encoder;
  std::uint16_t pot = 0;
  std::uint16_t current = 0;  ///< measured current in bits of the ADC
  double seconds = 0.0;       ///< [s] since the previous read, see BoardFeedback::seconds()
};

/// State of an arm in SI units; n entries each [rad, m], [rad/s, m/s], [N m, N], [A].
struct BoardArmState {
  explicit BoardArmState(int n = 0);

  VectorXd q, dq, tau;                             ///< Joint values; tau from measured currents
  VectorXd actuator_q, actuator_dq, actuator_tau;
  VectorXd current;                                ///< measured [A]
  VectorXd pot_q;                                  ///< actuator positions from the pots
};

/// Result of a command after limits.
struct ArmCommand {
  explicit ArmCommand(int n = 0);

  std::vector<std::uint16_t> bits;  ///< words of the converters, one per actuator
  VectorXd current;                 ///< [A] after clipping
  VectorXd tau;                     ///< joint torques for these currents
  bool clipped = false;             ///< an actuator would have needed more than its largest current
  bool valid = false;               ///< false: the torques were not finite, and all currents are zero
};

/// Counts, bits and volts of one arm's boards to SI units and back, through its coupling:
///
///   joint q = K actuator q,   actuator tau = K' joint tau,   K: actuators to joints
///
/// Everything is allocated and checked in the constructor; read() and write() never throw or
/// allocate. One object serves one thread: velocities from differences have a memory.
class ArmUnits {
 public:
  /// @param actuator_to_joint  (n x n) K; empty: identity.
  /// @throws InvalidInput  no actuators, one without drive or encoder, K is singular or of the
  /// wrong size.
  explicit ArmUnits(const RobotConfig& robot, const MatrixXd& actuator_to_joint = MatrixXd());

  int size() const { return static_cast<int>(actuators_.size()); }  ///< number of actuators
  const RobotConfig& robot() const { return robot_; }
  const MatrixXd& actuator_to_joint() const { return actuator_to_joint_; }
  const MatrixXd& joint_to_actuator() const { return joint_to_actuator_; }

  /// (n) Largest change of each joint's position when every encoder moves by one count [rad, m].
  VectorXd joint_steps() const;

  /// Converts readings of all boards to SI units.
  /// @param raw    size() entries, in the order of the configuration.
  /// @param state  of size().
  void read(const RawActuator* raw, BoardArmState& state) noexcept;

  /// Bits for joint torques. Every current is limited to its actuator's largest; torques that are not finite
  /// give zero current everywhere.
  /// @param tau  (n) [N m, N], a stored vector.
  void write(const VectorRef& tau, ArmCommand& command) noexcept;

  /// Bits of zero current, which differ from 0x8000 by the calibration.
  void write_zero(ArmCommand& command) noexcept;

  /// Positions of the actuators from the mean of pot readings [bits].
  void pot_positions(const VectorRef& mean_bits, VectorXd& actuator_q) noexcept;

  /// Words that load the encoders with positions of the actuators [rad, m].
  void preload_words(const VectorRef& actuator_q, std::uint32_t* words) const noexcept;

  /// Forgets the previous counts, after the encoders were loaded.
  void reset() noexcept { has_previous_ = false; }

 private:
  void convert_currents(ArmCommand& command) noexcept;  ///< sets bits and tau from the currents [A]

  RobotConfig robot_;
  std::vector<ActuatorConfig> actuators_;
  MatrixXd actuator_to_joint_;
  MatrixXd joint_to_actuator_;
  MatrixXd joint_torque_;     ///< inverse of K', actuator to joint torques
  MatrixXd actuator_torque_;  ///< K'
  std::vector<std::int32_t> previous_;
  bool has_previous_ = false;
  VectorXd pot_;
  VectorXd effort_;
};

}  // namespace veridyn::dvrk
