#pragma once

#include "veridyn/control/cooperative_controller.hpp"
#include "veridyn/cooperation/scenario.hpp"

namespace veridyn {

/// Gives a command of a phase to the controller; letting go and taking hold also need the world.
/// False where the controller refuses it.
bool apply_command(const ScenarioCommand& command, CooperativeController& control) noexcept;

}  // namespace veridyn
