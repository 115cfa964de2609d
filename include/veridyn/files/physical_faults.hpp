#pragma once

#include <string>
#include <vector>

#include "veridyn/model/model.hpp"

namespace veridyn {

/// A sentence on a body that cannot be, as below; empty: it can.
std::string body_fault(const std::string& name, const InertialParameters& phi);

/// Sentences about what no physical arm has: no body at all, a moving body with inertia but without
/// mass, a principal moment of inertia that is negative or larger than the sum of the other two by
/// more than 1 % (printed digits round), a coordinate that moves no mass where all bodies have
/// values. Bodies without values, and those that do not move, are not judged.
/// @returns nothing where the arm can exist.
std::vector<std::string> physical_faults(const Model& arm);

}  // namespace veridyn
