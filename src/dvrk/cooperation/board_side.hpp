#pragma once

#include <memory>
#include <optional>

#include "cooperation/arm_loop.hpp"
#include "cooperation/scenario_models.hpp"
#include "veridyn/control/safety_supervisor.hpp"
#include "veridyn/model/joint_sensors.hpp"
#include "dvrk/run/arm_session.hpp"
#include "dvrk/cooperation/board_cooperation.hpp"

namespace veridyn::dvrk {

/// One arm of a scenario on its boards: line, session, control loop, safety supervisor. Nothing
/// allocates, throws or blocks after begin(), except that a read waits for its reply_timeout.
class BoardSide {
 public:
  /// @param link  of the arm's boards, which are then looked for.
  /// @throws InvalidInput  as ArmSession::start(); more joints than actuators.
  BoardSide(const Scenario& scenario, std::size_t index, const CooperatingArm& arm,
            const BoardCooperationOptions& options, std::unique_ptr<DatagramLink> link);

  /// Control begins where the arm stands. @throws InvalidInput  its boards have never answered.
  void begin(const Scenario& scenario, std::size_t index);

  /// Reads its boards, unless they are deaf.
  void read(double now) noexcept;
  void write() noexcept { session_.commit(); }

  /// Its loop and its supervisor for this cycle; only while its boards are ready and answered.
  /// @param exerted  force of the tip on the object as measured [N]. @param age  [s] of it.
  void act(const TipTarget& target, const Eigen::Vector3d& exerted, double age,
           double dt) noexcept;

  /// The same with torques from elsewhere, (joints).
  void drive(const VectorXd& tau, const Eigen::Vector3d& exerted, double age, double dt) noexcept;

  /// Why the arm is lost, in fixed words and once; nullptr: it is not, or it was said before.
  /// @param largest_age  [s] without a valid read.
  const char* lost_by(double largest_age) noexcept;

  ArmLoop& loop() { return *loop_; }
  const ArmLoop& loop() const { return *loop_; }
  ArmSession& session() { return session_; }
  DatagramLink& link() { return *link_; }
  const ScenarioModels& models() const { return models_; }
  const VectorXd& q() const { return q_; }  ///< true, as far as the model knows its sensors
  const VectorXd& dq() const { return dq_; }
  const VectorXd& tau() const { return tau_; }  ///< true torques
  int joints() const { return joints_; }
  bool valid() const { return valid_; }
  bool deaf() const { return deaf_; }  ///< It does not answer, and is not asked any more.
  const SafetySupervisor* supervisor() const { return supervisor_.get(); }  ///< null before power

 private:
  ScenarioModels models_;
  std::unique_ptr<DatagramLink> link_;
  ArmSession session_;
  JointSensors sensors_;
  int joints_;
  VectorXd q_, dq_, tau_, all_;
  veridyn::ArmState state_;
  SafetyInput input_;
  std::optional<ArmLoop> loop_;
  std::unique_ptr<SafetySupervisor> supervisor_;
  bool valid_ = false, lost_ = false, deaf_ = false;
  double now_ = 0.0, heard_ = 0.0;  // [s] of this cycle and of the last valid read
};

}  // namespace veridyn::dvrk
