#include <cmath>

#include "pendulum.hpp"
#include "veridyn/dynamics/rigid_body_dynamics.hpp"

int main() {
  const veridyn::VectorXd rest = veridyn::VectorXd::Zero(1);
  const double tau = veridyn::inverse_dynamics(pendulum(), rest, rest, rest)[0];
  return std::abs(tau - 2.0 * 9.81 * 0.5) < 1e-12 ? 0 : 1;
}
