// Steps of one joint after the other under computed torque, with the gains of figure 7.3 of the thesis: 0.05
// rad, 0.05 rad, 5 mm, each over one second. First with friction compensation and the observer of model
// errors, then without both.
//
//   example_07_joint_steps psm_identified.yaml      written by 01_identify

#include <iostream>

#include "simulated_robot.hpp"
#include "veridyn/control.hpp"

using namespace veridyn;

// Largest distance of a joint from its goal [rad], [m] when the next one begins, two seconds after its step.
double steps(const Model& arm, const JointControllerOptions& options) {
  SimulatedRobot robot({"payload:tool:mass=0.05"});  // which the MODEL does not contain
  JointController controller(arm, options);
  Measured measured(3);
  robot.read(measured.q);
  JointReference wanted = controller.reference_at(measured);
  QuinticInterpolator path(wanted.q);
  VectorXd error(3);
  for (int joint = 0; joint < 3; ++joint) {
    path.move_to(path.goal() + Eigen::Vector3d(0.05, 0.05, 0.005)[joint] * Eigen::Vector3d::Unit(joint), 1.0);
    for (int k = 0; k < 3000; ++k) {
      robot.read(measured.q);
      path.advance(SimulatedRobot::kCycle);
      set_reference_from(path, wanted);
      robot.write(controller.update(measured, wanted, SimulatedRobot::kCycle));
    }
    error[joint] = std::abs(wanted.q[joint] - controller.state().q()[joint]);
  }
  std::cout << "error after the steps: " << 1e3 * error.transpose() << " mrad, mrad, mm\n";
  return error.maxCoeff();
}

int main(int argc, char** argv) {
  const Model arm = read_model(argc > 1 ? argv[1] : "psm_identified.yaml");
  JointControllerOptions options{.kp = {25, 20, 75}, .kd = {10, 11, 15}, .cycle = {.error_limit = 1.0, .torque = 40}};
  const double compensated = steps(arm, options);
  options.cycle.friction.share = options.cycle.error_bandwidth = 0.0;
  return compensated < 0.1 * steps(arm, options) ? 0 : 1;
}
