// Two arms hold a spring: forces and lengths are those of a simulation here, and of the arms later.
#include <iostream>

#include "veridyn/control/cooperative_controller.hpp"

int main() {
  using Eigen::Vector3d;
  constexpr double kStiffness = 2450.0;                              // of the spring [N/m]
  std::vector<Vector3d> tips{{0.55, 0.0, 0.03}, {0.67, 0.0, 0.03}};  // [m] in the world
  const double rest = (tips[1] - tips[0]).norm();

  veridyn::CooperativeOptions options;
  options.R_world_arm.assign(2, Eigen::Matrix3d::Identity());
  veridyn::ForceLaw law;
  law.gain = 0.004;  // [m/(N s)]: a crossover of 10 rad/s on this spring
  law.stiffness = kStiffness;
  options.members = {{0, 1, law, 1.0}};
  veridyn::CooperativeController control(options, tips);
  control.set_force(0, 5.0, 1.0);               // newtons, within a second
  control.move(Vector3d(0.05, 0.0, 0.0), 3.0);  // metres

  veridyn::CooperativeInput input(2, 1);
  for (int k = 0; k < 5000; ++k) {
    input.position = tips;
    input.force[0] = {kStiffness * ((tips[1] - tips[0]).norm() - rest), 0.0, k};
    const auto& targets = control.update(input);
    for (size_t i = 0; i < 2; ++i) {
      input.velocity[i] = (targets[i].position - tips[i]) / options.period;
      tips[i] = targets[i].position;  // arms that do as they are told
    }
  }
  std::cout << "force " << input.force[0].force << " N, master at x = " << tips[0].x() << " m\n"
            << "the controller " << describe(control.state()) << "\n";
}
