#include <cmath>
#include <iostream>

#include "veridyn/dynamics/arm_dynamics.hpp"

// A pendulum of 2 kg at 0.5 m about a horizontal axis, in floats: with the headers and Eigen, and
// without the library.

int main() {
  using veridyn::JointType;
  veridyn::Tree tree(1, {0, 0, -9.81});
  const veridyn::Posed T_world_joint{veridyn::rotation_x(M_PI / 2), {0, 0, 1}};
  tree.add_body(tree.add_link(-1, JointType::kRevolute, {{0, 1.0}}, 0.0, T_world_joint));
  const double phi[] = {2, 1, 0, 0, 0, 0, 0.5, 0, 0, 0.5};  // along x of the link
  veridyn::ArmDynamics<float> arm(tree, phi);
  Eigen::VectorXf q(1), dq(1), ddq(1), tau(1);
  q << 0.3F;
  dq << 1.0F;
  ddq << 2.0F;
  arm.inverse_dynamics(q, dq, ddq, tau);
  const double expected = 0.5 * 2.0 + 2.0 * 9.81 * 0.5 * std::cos(0.3);
  std::cout << tau[0] << " N m, expected " << expected << "\n";
  return std::abs(tau[0] - expected) < 1e-5 ? 0 : 1;
}
