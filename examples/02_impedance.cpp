// An arm that gives way: impedance control against a spring, by an identified MODEL, of an arm that
// carries an instrument which the MODEL does not know and has more friction than it had.
//
//   example_02_impedance psm_identified.yaml      what 01_identify writes

#include <algorithm>
#include <iostream>

#include "simulated_robot.hpp"
#include "veridyn/control.hpp"

int main(int argc, char** argv) {
  using namespace veridyn;
  const Model arm = read_model(argc > 1 ? argv[1] : "psm_identified.yaml");
  SimulatedRobot robot({"payload:tool:mass=0.05", "coulomb_friction:pitch:level=0.1"});
  const Tip tip{"tool"};
  const double dt = SimulatedRobot::kCycle;

  JointSensors sensors(arm);
  VelocityObserver velocity(3);
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

  VectorXd q(3), dq(3), tau(3);
  SafetyInput input(3);
  input.q_wanted.setConstant(NAN);  // the arm may leave its path
  input.force_expected.setConstant(NAN);
  TaskReference wanted;
  Eigen::Vector3d anchor;
  Vector6d wrench = Vector6d::Zero();
  for (int k = 0; k < 3000; ++k) {
    robot.read(q);
    sensors.correct_positions(q);
    dq = velocity.update(q, control.acceleration(), dt);
    state.update(q, dq);
    if (k == 0) anchor = wanted.x.head<3>() = state.tip().position();
    wanted.x.x() = anchor.x() + 0.055 * std::min(1.0, 0.001 * k);  // pulls with about 5 N
    wrench.head<3>() = 1000.0 * (state.tip().position() - anchor);  // what a force sensor says
    tau = control.update(state, wanted, wrench);
    tau += friction.update(state, control.joint_velocity(), control.joint_error(), dt);
    tau += error.update(state, control.acceleration(), dt);
    input.force = wrench.head<3>();
    const VectorXd& sent = safety.update(state, input, tau);
    error.sent(tau, sent);
    tau = sent;
    sensors.show_torques(tau);
    robot.push(-(state.tip().jacobian().transpose() * wrench));  // the spring on the arm
    if (!robot.write(tau)) return 1;
  }
  const double force = wrench.head<3>().norm();
  std::cout << "force " << force << " N, safety: " << describe(safety.state()) << " ("
            << describe(safety.fault()) << ")\n";
  return std::abs(force - 5.0) < 0.5 ? 0 : 1;
}
