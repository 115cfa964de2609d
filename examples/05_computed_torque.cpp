// Computed torque with an identified MODEL, on an arm that differs from the MODEL: it carries a load that it
// did not have when it was identified, and its drives are slightly too strong.
//
//   example_05_computed_torque psm_identified.yaml      written by 01_identify

#include <iostream>

#include "simulated_robot.hpp"
#include "veridyn/control.hpp"

int main(int argc, char** argv) {
  using namespace veridyn;
  const Model arm = read_model(argc > 1 ? argv[1] : "psm_identified.yaml");
  SimulatedRobot robot({"payload:tool:mass=0.1", "torque_gain:pitch:gain=0.95"});  // or a real one
  JointController controller(arm, {.kp = 400, .kd = 40, .cycle = {.torque = 40}});
  Measured measured(arm.joints());
  robot.read(measured.q);
  JointReference wanted = controller.reference_at(measured);
  QuinticInterpolator path(wanted.q);  // begins at the arm's position
  path.move_to(wanted.q + Eigen::Vector3d(0.4, -0.3, 0.05), 2.0);
  double worst = 0.0;
  for (int k = 0; k < 3000; ++k) {
    robot.read(measured.q);
    path.advance(SimulatedRobot::kCycle);
    set_reference_from(path, wanted);
    robot.write(controller.update(measured, wanted, SimulatedRobot::kCycle));
    worst = std::max(worst, (robot.true_q() - wanted.q).cwiseAbs().maxCoeff());
  }
  std::cout << "largest error " << 1e3 * worst << " mrad or mm\n";
  if (controller.fault()) std::cout << *controller.fault() << "\n";
  return !controller.fault() && worst < 0.02 ? 0 : 1;
}
