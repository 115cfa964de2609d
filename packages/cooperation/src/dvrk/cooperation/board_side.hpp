#pragma once

#include <memory>
#include <optional>

#include "cooperation/arm_loop.hpp"
#include "cooperation/scenario/scenario_models.hpp"
#include "veridyn/control/momentum_observer.hpp"
#include "veridyn/control/safety_supervisor.hpp"
#include "veridyn/model/joint_sensors.hpp"
#include "veridyn/dvrk/run/arm_session.hpp"
#include "dvrk/cooperation/board_cooperation.hpp"

namespace veridyn::dvrk {

/// One arm of a scenario on its boards: link, session, control loop, safety supervisor. Nothing allocates,
/// throws or blocks after begin(), except that a read waits for its reply_timeout.
class BoardSide {
 public:
  /// @param link  to the arm's boards, which the constructor searches for.
  /// @throws InvalidInput  as ArmSession::start(); more joints than actuators.
  BoardSide(const Scenario& scenario, std::size_t index, const CooperatingArm& arm,
            const BoardCooperationOptions& options, std::unique_ptr<DatagramLink> link);

  /// Starts control at the arm's present position. @throws InvalidInput  its boards never answered.
  void begin(const Scenario& scenario, std::size_t index);

  /// Reads its boards at `now` [s], unless they are unresponsive; see valid().
  void read(double now) noexcept;
  void write() noexcept { session_.commit(); }

  /// Runs the arm's loop and supervisor for this cycle; only while its boards are ready and answer.
  /// @param exerted  force of the tip on the object as measured [N], in the world. @param age  [s] of it.
  /// @param dt  [s] period of the cycle.
  void act(const TipTarget& target, const Eigen::Vector3d& exerted, double age, double dt) noexcept;

  /// The supervisor alone, with given true torques (joints) [N m], [N].
  void drive(const VectorXd& tau, const Eigen::Vector3d& exerted, double age, double dt) noexcept;

  /// From now on act() compares the measured force with the estimate from the motors' torques.
  void compare_forces() noexcept { compares_ = true; }

  /// Declares that the controller holds the arm, whose supervisor then requires it to come to rest.
  void set_held(bool held) noexcept { input_.held = held; }

  /// A newly detected fault, as fixed text; `what` null: none.
  struct News {
    const char* what = nullptr;
    std::optional<JointIndex> joint = {};
    /// The measured force must not be used: the torques of the motors do not explain it, or it is too old.
    bool unexplained = false, old_force = false;
  };
  /// The next fault that was not yet reported. @param largest_age  [s] without a valid read.
  News poll_faults(double largest_age) noexcept;

  /// Difference between the measured force and that explained by the motors' torques [N]; NaN if they are not
  /// compared.
  double unexplained_force() const noexcept { return (input_.force - input_.force_expected).norm(); }

  /// Position of the tip, and largest speed of a joint as a share of its limit, at the last read.
  const Eigen::Vector3d& tip() const { return loop_->position(); }
  double speed() const noexcept { return dq_.cwiseQuotient(velocity_).cwiseAbs().maxCoeff(); }

  ArmLoop& loop() { return *loop_; }
  const ArmLoop& loop() const { return *loop_; }
  ArmSession& session() { return session_; }
  DatagramLink& link() { return *link_; }
  const ScenarioModels& models() const { return models_; }
  const VectorXd& q() const { return q_; }  ///< true, as far as the model contains the errors of its sensors
  const VectorXd& dq() const { return dq_; }
  const VectorXd& tau() const { return tau_; }  ///< true torques
  int joints() const { return joints_; }
  /// Torques (n) that the motors can give and the robot file allows [N m], [N].
  VectorXd largest_torque() const;
  bool valid() const { return valid_; }
  /// True if its power is on or being switched on.
  bool powered() const {
    const PowerState state = session_.boards().state();
    return state != PowerState::kOff && state != PowerState::kFault;
  }
  bool is_unresponsive() const { return deaf_; }  ///< True if it does not answer and is no longer polled.
  const SafetySupervisor* supervisor() const { return supervisor_.get(); }  ///< null before power

 private:
  ScenarioModels models_;
  std::unique_ptr<DatagramLink> link_;
  ArmSession session_;
  JointSensors sensors_;
  int joints_;
  VectorXd q_, dq_, tau_, rest_, all_;
  veridyn::ArmState state_;
  MomentumObserver touch_;
  SafetyInput input_;
  std::optional<ArmLoop> loop_;
  std::unique_ptr<SafetySupervisor> supervisor_;
  VectorXd velocity_;  // limits
  FaultChecks checks_;
  bool valid_ = false, deaf_ = false, reported_silence_ = false, told_off_ = false, cut_ = false, compares_ = false;
  int told_ = 0;  // number of reported events of the supervisor
  double now_ = 0.0, heard_ = 0.0;  // [s] times of this cycle and of the last valid read
  std::optional<double> acted_;     // [s] time of the supervisor's last update
};

}  // namespace veridyn::dvrk
