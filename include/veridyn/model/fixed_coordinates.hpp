#pragma once

#include <map>
#include <string>
#include <vector>

#include "veridyn/model/model.hpp"

namespace veridyn {

/// The arm with some of its coordinates held at a position for good: a gripper's finger that is not
/// recorded, a wrist that is locked. Their share of every joint variable becomes part of its
/// offset,
///
///   s = c . q + s0 = c_rest . q_rest + (s0 + c_fixed . q_fixed)
///
/// effects along them alone are left out, and their limits with them.
///
/// @param positions  by name of the coordinate [rad] or [m].
/// @throws InvalidInput  no such coordinate, or none would be left.
Model with_fixed(const Model& arm, const std::map<std::string, double>& positions);

/// The arm with these torques per ampere of motor current, one for each coordinate [N m/A], [N/A].
/// @throws InvalidInput  another number of them, or one that is zero or not finite.
Model with_drive_gains(const Model& arm, const std::vector<double>& gains);

}  // namespace veridyn
