#pragma once

#include <atomic>
#include <string>
#include <vector>

#include "veridyn/cooperation/scenario.hpp"
#include "emulator/joined_arms.hpp"
#include "veridyn/dvrk/arms/arm_facts.hpp"
#include "dvrk/cooperation/board_cooperation.hpp"

namespace veridyn::dvrk {

/// examples/dvrk/NAME.yaml.
inline Scenario board_example(const std::string& name) {
  return read_scenario(std::string(VERIDYN_SOURCE_DIR) + "/examples/dvrk/" + name + ".yaml");
}

/// PSM1, PSM2, ... as their nominal configurations are.
inline std::vector<CooperatingArm> patient_side(std::size_t count) {
  std::vector<CooperatingArm> arms;
  for (std::size_t k = 0; k < count; ++k) {
    const ArmFacts arm = read_arm("PSM" + std::to_string(k + 1));
    CooperatingArm one;
    one.robot = nominal_config(arm).robot("");
    one.coupling = arm.coupling();
    arms.push_back(one);
  }
  return arms;
}

/// On emulated boards, over UDP sockets, by a clock that does not depend on the machine.
inline BoardCooperationRun on_emulated_boards(const Scenario& scenario,
                                              const std::vector<EmulatedFault>& faults = {},
                                              bool stepped = true) {
  BoardCooperationOptions options;
  options.emulate = emulate_boards;
  options.stepped = stepped;
  options.faults = faults;
  options.hold = 0.4;
  options.rehearsed = false;  // the tests inspect the run itself, whether or not its bounds are met
  std::atomic<bool> stop{false};
  return run_on_boards(scenario, patient_side(scenario.arms.size()), options, stop);
}

}  // namespace veridyn::dvrk
