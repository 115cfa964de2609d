#include "veridyn/control/tip_controller.hpp"

namespace veridyn {
namespace {

ImpedanceGains gains_of(const TipControllerOptions& options) {
  ImpedanceGains gains;
  gains.mass = options.mass.expand(6, "mass");
  gains.damping = options.damping.expand(6, "damping");
  gains.stiffness = options.stiffness.expand(6, "stiffness");
  return gains;
}

}  // namespace

TipController::TipController(const Model& arm, const TipControllerOptions& options)
    : TipController(arm, chosen_tip(arm, options.tip), options) {}

TipController::TipController(const Model& arm, const Tip& tip, const TipControllerOptions& options)
    : cycle_(arm, tip, options.cycle), impedance_(arm, tip, gains_of(options), options.impedance) {
  update(Measured(arm.joints()), TaskReference(), 0.0);  // touches all memory, so that the first cycle waits for none
  reset();
}

const VectorXd& TipController::act(const TaskReference& reference) noexcept {
  cycle_.command(impedance_.update(cycle_.state(), reference, cycle_.wrench()));
  cycle_.add_friction(impedance_.joint_velocity(), impedance_.joint_error());
  cycle_.add_model_error(impedance_.acceleration());
  return cycle_.send();
}

TaskReference TipController::reference_at(const Measured& measured) const {
  VectorXd q = measured.q;
  cycle_.sensors().correct_positions(q);
  TipKinematics tip = state().tip();
  tip.update(q, VectorXd::Zero(q.size()));
  TaskReference out;
  out.x = impedance_.task().coordinates(tip.position(), tip.rotation());
  return out;
}

}  // namespace veridyn
