// A compliant arm: impedance control against a spring, with an identified MODEL, of an arm that carries an
// instrument and has more friction than the MODEL contains.
//
//   example_02_impedance psm_identified.yaml      written by 01_identify

#include <algorithm>
#include <iostream>

#include "simulated_robot.hpp"
#include "veridyn/control.hpp"

int main(int argc, char** argv) {
  using namespace veridyn;
  const Model arm = read_model(argc > 1 ? argv[1] : "psm_identified.yaml");
  SimulatedRobot robot({"payload:tool:mass=0.05", "coulomb_friction:pitch:level=0.1"});
  TipController controller(arm, {.mass = 2, .damping = 100, .stiffness = 100, .tip = {"tool"},
                                 .cycle = {.error_limit = 1.0, .torque = 40}});
  Measured measured(arm.joints());
  robot.read(measured.q);
  TaskReference wanted = controller.reference_at(measured);
  const Eigen::Vector3d anchor = wanted.x.head<3>();
  for (int k = 0; k < 3000; ++k) {
    robot.read(measured.q);
    wanted.x.x() = anchor.x() + 0.055 * std::min(1.0, 0.001 * k);  // pulls with about 5 N
    const TipKinematics& tip = controller.measure(measured, SimulatedRobot::kCycle).tip();
    robot.push(-(tip.jacobian().transpose() * measured.wrench));  // the spring on the arm
    robot.write(controller.act(wanted));
    measured.wrench.head<3>() = 1000.0 * (tip.position() - anchor);  // reading of a force sensor
  }
  const double force = measured.wrench.head<3>().norm();
  std::cout << "force " << force << " N\n";
  if (controller.fault()) std::cout << *controller.fault() << "\n";
  return std::abs(force - 5.0) < 0.5 && !controller.fault() ? 0 : 1;
}
