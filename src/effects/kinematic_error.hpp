#pragma once

#include "veridyn/effects/cause.hpp"

namespace veridyn {

/// The present value of a wrong constant: a number of a frame's row; zero for a joint's zero.
/// Constants with a name are not supported, because other numbers depend on them.
double value_of(const KinematicError& error, const ModelDescription& arm);

/// Sets that value. A zero shifts all joint variables that the coordinate is part of.
void set_value(const KinematicError& error, double value, ModelDescription& arm);

}  // namespace veridyn
