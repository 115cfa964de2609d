#pragma once

#include "veridyn/control/cooperative_controller.hpp"
#include "veridyn/cooperation/scenario.hpp"

namespace veridyn {

/// Passes a command of a phase to the controller. Releasing and attaching also concern the world. False if
/// the controller refuses it.
bool apply_command(const ScenarioCommand& command, CooperativeController& control) noexcept;

}  // namespace veridyn
