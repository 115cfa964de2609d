#include <cmath>

#include "pendulum.hpp"
#include "veridyn/control/computed_torque.hpp"

int main() {
  using namespace veridyn;
  ArmState state(pendulum(), Tip{"rod"});
  ComputedTorque control(1, {VectorXd::Constant(1, 25.0), VectorXd::Constant(1, 10.0)});
  state.update(VectorXd::Zero(1), VectorXd::Zero(1));
  const double tau = control.update(state, JointReference(1))[0];
  return std::abs(tau - 2.0 * 9.81 * 0.5) < 1e-12 ? 0 : 1;
}
