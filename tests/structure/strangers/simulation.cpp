#include "pendulum.hpp"
#include "veridyn/simulation/plant.hpp"

int main() {
  veridyn::Plant plant(pendulum());
  plant.set_state(veridyn::VectorXd::Zero(1), veridyn::VectorXd::Zero(1));
  for (int k = 0; k < 10; ++k) plant.step(veridyn::VectorXd::Zero(1), 0.001);
  return plant.q()[0] < 0.0 ? 0 : 1;  // it falls
}
