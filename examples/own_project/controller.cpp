// The torques of the first cycle of computed torque, for the arm of a MODEL at rest; a loop around
// the last line makes a controller (docs/control.md).

#include <iostream>

#include "veridyn/control.hpp"

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: controller MODEL\n";
    return 2;
  }
  try {
    veridyn::JointControllerOptions options{400, 40};  // K_p [1/s^2], K_d [1/s]
    options.cycle.torque = 40;                          // [N m], [N] where the MODEL gives no limit
    const veridyn::Model arm = veridyn::read_model(argv[1]);
    veridyn::JointController controller(arm, options);
    veridyn::Measured measured(arm.joints());  // positions as measured by the encoders
    const veridyn::JointReference wanted(arm.joints());
    std::cout << controller.update(measured, wanted, 1e-3).transpose() << "\n";
  } catch (const veridyn::InvalidInput& bad) {
    std::cerr << bad.what() << "\n";
    return 3;
  }
}
