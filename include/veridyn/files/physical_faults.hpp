#pragma once

#include <string>
#include <vector>

#include "veridyn/model/model.hpp"

namespace veridyn {

/// A sentence if the body is physically impossible, as below; empty otherwise.
std::string body_fault(const std::string& name, const InertialParameters& phi);

/// Sentences about properties that no physical arm has: no body at all, a moving body with inertia but
/// without mass, a principal moment of inertia that is negative or larger than the sum of the other two by
/// more than 1 % (rounding of printed digits), a coordinate that moves no mass although all bodies have
/// values. Bodies without values, and those that do not move, are not checked.
/// @returns an empty list if the arm is possible.
std::vector<std::string> physical_faults(const Model& arm);

}  // namespace veridyn
