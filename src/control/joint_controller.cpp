#include "veridyn/control/joint_controller.hpp"

#include <cassert>

namespace veridyn {

JointController::JointController(const Model& arm, const JointControllerOptions& options)
    : cycle_(arm, chosen_tip(arm), options.cycle),
      law_(options.law),
      error_(VectorXd::Zero(arm.joints())),
      tau_(error_) {
  const int n = arm.joints();
  const VectorXd p = options.kp.expand(n, "kp"), d = options.kd.expand(n, "kd"), i = options.ki.expand(n, "ki");
  switch (law_) {
    case JointLaw::kComputedTorque:
      computed_torque_.emplace(n, JointGains{p, d});
      break;
    case JointLaw::kGravity:
      gravity_.emplace(arm);
      break;
    case JointLaw::kPid:
      pid_.emplace(PidGains{p, i, d}, PidLimits{cycle_.limits().torque, cycle_.limits().torque});
      break;
  }
  update(Measured(n), JointReference(n), 0.0);  // touches all memory, so that the first cycle waits for none
  reset();
}

const VectorXd& JointController::act(const JointReference& reference) noexcept {
  assert(reference.q.size() == error_.size() && reference.dq.size() == error_.size());
  const ArmState& state = cycle_.state();
  switch (law_) {
    case JointLaw::kComputedTorque:
      error_ = reference.q - state.q();
      cycle_.command(computed_torque_->update(state, reference));
      cycle_.add_friction(reference.dq, error_);
      cycle_.add_model_error(computed_torque_->acceleration());
      cycle_.set_wanted_positions(reference.q);
      break;
    case JointLaw::kGravity:
      cycle_.command(gravity_->update(state.q()));
      break;
    case JointLaw::kPid:
      pid_->torques(state.q(), state.dq(), reference.q, reference.dq, dt_, tau_);
      cycle_.command(tau_);
      cycle_.set_wanted_positions(reference.q);
      break;
  }
  return cycle_.send();
}

JointReference JointController::reference_at(const Measured& measured) const {
  JointReference out(joints());
  out.q = measured.q;
  cycle_.sensors().correct_positions(out.q);
  return out;
}

void JointController::reset() noexcept {
  cycle_.reset();
  if (pid_) pid_->reset();
}

}  // namespace veridyn
