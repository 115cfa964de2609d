#include "phase_commands.hpp"

namespace veridyn {

bool apply_command(const ScenarioCommand& c, CooperativeController& control) noexcept {
  switch (c.kind) {
    case ScenarioCommand::Kind::kMove:
      return control.move(c.way, c.over);
    case ScenarioCommand::Kind::kTurn:
      return control.rotate(c.way, c.over);
    case ScenarioCommand::Kind::kTighten:
      return control.expand_grasp(c.amount, c.over);
    case ScenarioCommand::Kind::kForce:
      return control.set_force(c.member, c.amount, c.over);
    case ScenarioCommand::Kind::kMoveArm:
      return control.move_arm(c.arm, c.way, c.over);
    case ScenarioCommand::Kind::kRelease:
      return control.track(c.member, false);
    case ScenarioCommand::Kind::kTake:
      return control.track(c.member, true);
  }
  return false;
}

}  // namespace veridyn
