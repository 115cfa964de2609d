#pragma once

#include <string>

#include "control/kinematics_table.hpp"

namespace veridyn {

/// JSON of `kinematics --json`: rows with q, position, quaternion (w, x, y, z), conditioning,
/// Jacobian, and the remaining error of inverse kinematics.
std::string to_json(const KinematicTable& table);

/// A page with this result, a drawing of the arm, and the conditioning over the workspace.
std::string to_page(const KinematicTable& table, const Model& arm, const std::string& command);

}  // namespace veridyn
