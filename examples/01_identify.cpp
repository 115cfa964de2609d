// From a recording to a model: the dynamics of an arm, with standard deviations.

#include <iostream>

#include "veridyn/identification/identification.hpp"
#include "veridyn/model/model_file.hpp"

int main() {
  const veridyn::Model arm = veridyn::read_model("psm-3dof");
  const veridyn::Recording log = veridyn::read_recording("fourier-1.csv");  // t, q, dq, tau
  // Base parameters, physically feasible.
  const veridyn::Identification id = veridyn::identify(arm, log);
  std::cout << id.report();  // status, rank gap, error per joint, std devs
  veridyn::save(id, "psm_identified.yaml");
}
