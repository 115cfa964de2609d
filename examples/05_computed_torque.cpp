// Computed torque with an identified MODEL, on an arm that is not quite what the MODEL says: it
// carries a load that it did not have when it was identified, and its drives are a bit too strong.
//
//   example_05_computed_torque psm_identified.yaml      what 01_identify writes

#include <iostream>

#include "simulated_robot.hpp"
#include "veridyn/control.hpp"

int main(int argc, char** argv) {
  using namespace veridyn;
  const Model arm = read_model(argc > 1 ? argv[1] : "psm_identified.yaml");
  SimulatedRobot robot({"payload:tool:mass=0.1", "torque_gain:pitch:gain=0.95"});  // or a real one
  const int n = arm.joints();
  const double dt = SimulatedRobot::kCycle;

  JointSensors sensors(arm);  // what the MODEL knows about encoders and drives
  VelocityObserver velocity(n);
  ArmState state(arm);
  ComputedTorque control(n, {VectorXd::Constant(n, 400.0), VectorXd::Constant(n, 40.0)});
  FrictionCompensation friction(arm);
  TorqueUncertainty uncertainty(arm);  // what the MODEL may be wrong by
  ModelErrorObserver error(n, {10.0, VectorXd::Zero(n)});
  SafetySupervisor safety(arm, safety_limits(arm, 40.0));
  for (const std::string& effect : state.left_out()) std::cout << "not compensated: " << effect << "\n";

  VectorXd q(n), dq(n), tau(n), sent(n), off(n);
  robot.read(q);
  sensors.correct_positions(q);
  QuinticInterpolator way(q);  // begins where the arm stands
  way.move_to(q + VectorXd(Eigen::Vector3d(0.4, -0.3, 0.05)), 2.0);
  JointReference wanted(n);
  SafetyInput input(n);
  input.force_expected.setConstant(NAN);  // nobody touches the arm
  safety.enable();
  safety.activate();
  double worst = 0.0;
  for (int k = 0; k < 3000; ++k) {
    robot.read(q);
    sensors.correct_positions(q);  // from here on positions are true ones
    dq = velocity.update(q, control.acceleration(), dt);
    way.advance(dt);
    wanted.q = input.q_wanted = way.x();
    wanted.dq = way.dx();
    wanted.ddq = way.ddx();
    off = wanted.q - q;
    state.update(q, dq);
    tau = control.update(state, wanted);
    tau += friction.update(state, wanted.dq, off, dt);
    error.set_limit(uncertainty.update(state, control.acceleration()));
    tau += error.update(state, control.acceleration(), dt);
    sent = safety.update(state, input, tau);
    error.sent(tau, sent);       // what limits took away is no error of the MODEL
    sensors.show_torques(sent);  // as the drives count
    if (!robot.write(sent)) return 1;
    worst = std::max(worst, (robot.true_q() - wanted.q).cwiseAbs().maxCoeff());
  }
  std::cout << "largest error " << 1e3 * worst << " mrad or mm, safety: " << describe(safety.state()) << "\n";
  return safety.fault() == SafetyFault::kNone && worst < 0.02 ? 0 : 1;
}
