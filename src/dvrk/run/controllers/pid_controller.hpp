#pragma once

#include "dvrk/run/controllers/joint_pid.hpp"
#include "dvrk/run/controllers/motion_controller.hpp"

namespace veridyn::dvrk {

/// PID per joint behind the interface of all controllers.
class PidController final : public MotionController {
 public:
  PidController(const PidGains& gains, const VectorXd& integral_limit, double dt)
      : pid_(gains, integral_limit), dt_(dt) {}

  void reset() noexcept override { pid_.reset(); }
  bool torques(const BoardArmState& state, const JointReference& wanted, const CycleTimes&,
               VectorXd& tau) noexcept override {
    pid_.torques(state.q, state.dq, wanted.q, wanted.dq, dt_, tau);
    return true;
  }

 private:
  JointPid pid_;
  double dt_;
};

}  // namespace veridyn::dvrk
