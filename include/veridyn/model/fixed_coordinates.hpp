#pragma once

#include <map>
#include <string>
#include <vector>

#include "veridyn/model/model.hpp"

namespace veridyn {

/// Returns the arm with some of its coordinates locked at a position, such as a gripper's finger
/// that is not recorded or a wrist that is clamped. Their share of every joint variable becomes
/// part of its offset,
///
///   s = c . q + s0 = c_rest . q_rest + (s0 + c_fixed . q_fixed)
///
/// effects along locked coordinates alone are removed, and the limits of these coordinates with
/// them.
///
/// @param positions  by name of the coordinate [rad] or [m].
/// @throws InvalidInput  no such coordinate, none would be left, or crosstalk from a locked one.
Model with_fixed(const Model& arm, const std::map<std::string, double>& positions);

/// Returns the arm with these torques per ampere of motor current, one for each coordinate [N m/A],
/// [N/A].
/// @throws InvalidInput  the number of gains is not n, or one of them is zero or not finite.
Model with_drive_gains(const Model& arm, const std::vector<double>& gains);

}  // namespace veridyn
