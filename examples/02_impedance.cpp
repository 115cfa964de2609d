// An arm that gives way: impedance control of a simulated da Vinci arm against a spring, with
// friction compensation, integral action within the model and a safety supervisor.

#include <algorithm>
#include <cmath>
#include <iostream>

#include "veridyn/control/friction_compensation.hpp"
#include "veridyn/control/impedance.hpp"
#include "veridyn/control/model_error_observer.hpp"
#include "veridyn/control/safety_supervisor.hpp"
#include "veridyn/model/model_file.hpp"
#include "veridyn/simulation/plant.hpp"
#include "veridyn/simulation/plausible_model.hpp"

int main() {
  using namespace veridyn;
  const Model arm = plausible_model(read_model("psm-3dof"), 1).arm;  // or a MODEL of `identify`
  const Tip tip{"tool"};
  const double dt = 0.001;

  ArmState state(arm, tip);
  ImpedanceGains gains;
  gains.mass.setConstant(2.0);         // [kg]
  gains.damping.setConstant(100.0);    // [N s/m]
  gains.stiffness.setConstant(100.0);  // [N/m]
  Impedance control(arm, tip, gains);
  FrictionCompensation friction(arm);
  ModelErrorObserver error(3, {10.0, VectorXd::Constant(3, 1.0)});
  SafetySupervisor safety(arm, safety_limits(arm, 40.0));
  safety.enable();
  safety.activate();

  Plant plant(arm);
  plant.set_state(Eigen::Vector3d(0.1, 0.05, 0.12), Eigen::Vector3d::Zero());
  state.update(plant.q(), plant.dq());
  TaskReference wanted;
  wanted.x.head<3>() = state.tip().position();
  const Eigen::Vector3d anchor = state.tip().position();
  SafetyInput input(3);
  input.q_wanted.setConstant(NAN);  // the arm may leave its path
  input.force_expected.setConstant(NAN);
  Vector6d wrench = Vector6d::Zero();
  VectorXd tau(3);
  for (int k = 0; k < 3000; ++k) {
    wanted.x.x() = anchor.x() + 0.055 * std::min(1.0, 0.001 * k);  // pulls with about 5 N
    state.update(plant.q(), plant.dq());
    wrench.head<3>() = 1000.0 * (state.tip().position() - anchor);  // what a force sensor says
    tau = control.update(state, wanted, wrench);
    tau += friction.update(state, control.joint_velocity(), control.joint_error(), dt);
    tau += error.update(state, control.acceleration(), dt);
    input.force = wrench.head<3>();
    const VectorXd& sent = safety.update(state, input, tau);
    error.sent(tau, sent);
    tau = sent - state.tip().jacobian().transpose() * wrench;  // the spring on the arm
    plant.step(tau, dt);
  }
  std::cout << "force " << wrench.head<3>().norm() << " N, safety: " << describe(safety.state())
            << " (" << describe(safety.fault()) << ")\n";
}
