// Two arms hold a spring between their tips, carry it by 5 cm and keep a force of 5 N in it. The controllers
// use the MODEL of the first arm; the second one carries a load that the MODEL does not contain.
//
//   example_03_cooperate psm_identified.yaml      written by 01_identify

#include <iostream>

#include "simulated_pair.hpp"
#include "veridyn/control.hpp"

using namespace veridyn;

int main(int argc, char** argv) {
  const Model model = read_model(argc > 1 ? argv[1] : "psm_identified.yaml");
  SimulatedPair robots({"payload:tool:mass=0.1"});
  std::vector<TipController> arms(2, TipController(model, {.mass = 1, .damping = 40, .stiffness = 400, .tip = {"tool"},
                                                           .cycle = {.error_limit = 2.0, .torque = 40}}));
  Measured measured(model.joints());
  CooperativeInput input(2, 1);
  const auto look = [&] {
    for (int a : {0, 1}) {
      robots.read(a, measured.q);
      const TipKinematics& tip = arms[a].measure(measured, SimulatedPair::kCycle).tip();
      input.position[a] = robots.base(a) + tip.position();
      input.velocity[a] = tip.twist().head<3>();
    }
  };
  look();
  CooperativeOptions options;
  options.R_world_arm.assign(2, Eigen::Matrix3d::Identity());
  options.members = {{0, 1, {.gain = 0.004, .stiffness = SimulatedPair::kStiffness}, 1.0}};
  CooperativeController control(options, input.position);
  control.set_force(0, 5.0, 1.0);                      // newtons, within a second
  control.move(Eigen::Vector3d(0.0, 0.05, 0.0), 3.0);  // metres
  for (int k = 0; k < 5000; ++k) {
    look();
    input.force[0] = {robots.force(), 0.0, k, robots.force()};
    const std::vector<TipTarget>& targets = control.update(input);
    for (int a : {0, 1}) robots.write(a, arms[a].act(in_base(targets[a], robots.base(a))));
    robots.step();
  }
  std::cout << "force " << robots.force() << " N, the controller " << describe(control.state()) << "\n";
  return std::abs(robots.force() - 5.0) < 0.25 ? 0 : 1;
}
