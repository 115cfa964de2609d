#include <iostream>

#include "veridyn/dynamics/rigid_body_dynamics.hpp"
#include "veridyn/files/model_file.hpp"

int main() {
  const veridyn::Model arm = veridyn::read_model("planar-2r");
  const veridyn::VectorXd zero = veridyn::VectorXd::Zero(arm.joints());
  std::cout << veridyn::inverse_dynamics(arm, zero, zero, zero).transpose() << "\n";
}
