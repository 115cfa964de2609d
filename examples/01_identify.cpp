// From recordings of an arm to a model that can be trusted, what it still gets wrong, and a controller.
//
//   example_01_identify psm-3dof one.csv two.csv held-out.csv      t, q, dq, tau

#include <iostream>

#include "veridyn/veridyn.hpp"

using namespace veridyn;

int main(int argc, char** argv) {
  if (argc < 4) return 2;
  const Model robot = read_model(argv[1]);
  const Recordings train = read_recordings(robot, {argv + 2, argv + argc - 1});
  const Recordings test = read_recordings(robot, {argv[argc - 1]});
  const Identification fit = identify(robot, train);
  for (const JointScore& joint : validate(fit, test)) std::cout << joint << '\n';
  const Diagnosis why = diagnose(fit, test);  // nothing is read or fitted twice
  for (const Finding& finding : why.findings) std::cout << finding << '\n';
  save(why.model, "psm_identified.yaml");
  JointController controller(why.model, {.kp = 400, .kd = 40, .cycle = {.torque = 40}});
  std::cout << why.verdict() << '\n';
}
