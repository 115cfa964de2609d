// Steps of one joint after the other under computed torque with gains of one's own, as figure 7.3 of
// the thesis: 0.05 rad, 0.05 rad, 5 mm, each over one second. First by the law alone, then with
// friction compensation and the observer of model errors.
//
//   example_07_joint_steps psm_identified.yaml 25,20,75 10,11,15      K_p [1/s^2], K_d [1/s]

#include <iostream>
#include <sstream>

#include "simulated_robot.hpp"
#include "veridyn/control.hpp"

using namespace veridyn;

VectorXd numbers(const std::string& words) {
  std::istringstream in(words);
  VectorXd out(3);
  for (double& x : out) {
    if (!(in >> x)) throw InvalidInput("found '" + words + "', expected three numbers");
    in.ignore(1, ',');
  }
  return out;
}

// Where each joint is off its goal [rad], [m] when the next one begins, two seconds after its step.
VectorXd steps(const Model& arm, const JointGains& gains, bool compensated) {
  SimulatedRobot robot({"payload:tool:mass=0.05"});  // which the MODEL does not know
  const double dt = SimulatedRobot::kCycle;
  JointSensors sensors(arm);
  VelocityObserver velocity(3);
  ArmState state(arm);
  ComputedTorque control(3, gains);
  FrictionCompensation friction(arm);
  ModelErrorObserver error(3, {10.0, VectorXd::Constant(3, 1.0)});
  VectorXd q(3), dq(3), tau(3), off(3), left(3);
  robot.read(q);
  sensors.correct_positions(q);
  QuinticInterpolator way(q);
  JointReference wanted(3);
  const Eigen::Vector3d size(0.05, 0.05, 0.005);
  for (int joint = 0; joint < 3; ++joint) {
    way.move_to(way.goal() + VectorXd(size[joint] * Eigen::Vector3d::Unit(joint)), 1.0);
    for (int k = 0; k < 3000; ++k) {
      robot.read(q);
      sensors.correct_positions(q);
      dq = velocity.update(q, control.acceleration(), dt);
      way.advance(dt);
      wanted.q = way.x();
      wanted.dq = way.dx();
      wanted.ddq = way.ddx();
      off = wanted.q - q;
      state.update(q, dq);
      tau = control.update(state, wanted);
      if (compensated) {
        tau += friction.update(state, wanted.dq, off, dt);
        tau += error.update(state, control.acceleration(), dt);
      }
      sensors.show_torques(tau);
      if (!robot.write(tau)) throw InvalidInput("the arm cannot go on");
    }
    left[joint] = std::abs(off[joint]);
  }
  return left;
}

int main(int argc, char** argv) {
  const Model arm = read_model(argc > 1 ? argv[1] : "psm_identified.yaml");
  const JointGains gains{numbers(argc > 2 ? argv[2] : "25,20,75"), numbers(argc > 3 ? argv[3] : "10,11,15")};
  const VectorXd alone = steps(arm, gains, false), with = steps(arm, gains, true);
  std::cout << "left of the steps, the law alone:            " << 1e3 * alone.transpose() << " mrad, mrad, mm\n"
            << "with friction compensation and the observer: " << 1e3 * with.transpose() << "\n";
  return with.maxCoeff() < 0.1 * alone.maxCoeff() ? 0 : 1;
}
