// The torques of one cycle of computed torque, for the arm of a MODEL at rest; a loop around them
// makes a controller (docs/control.md).

#include <iostream>

#include "veridyn/control.hpp"

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: controller MODEL\n";
    return 2;
  }
  try {
    const veridyn::Model arm = veridyn::read_model(argv[1]);
    const int n = arm.joints();
    veridyn::JointSensors sensors(arm);
    veridyn::ArmState state(arm);
    veridyn::ComputedTorque control(
        n, {veridyn::VectorXd::Constant(n, 400.0), veridyn::VectorXd::Constant(n, 40.0)});
    veridyn::JointReference wanted(n);
    veridyn::VectorXd q = veridyn::VectorXd::Zero(n), dq = q;  // as the encoders show them
    sensors.correct_positions(q);
    state.update(q, dq);
    veridyn::VectorXd tau = control.update(state, wanted);
    sensors.show_torques(tau);
    std::cout << tau.transpose() << "\n";
  } catch (const veridyn::InvalidInput& bad) {
    std::cerr << bad.what() << "\n";
    return 3;
  }
}
