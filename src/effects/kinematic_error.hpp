#pragma once

#include "veridyn/effects/cause.hpp"

namespace veridyn {

/// A number of a frame's row as it stands; of a joint's zero nothing. Not of a constant with a name,
/// which other numbers depend on.
double value_of(const KinematicError& error, const ModelDescription& arm);

/// Gives it another value. A zero moves all joint variables that the coordinate is part of.
void set_value(const KinematicError& error, double value, ModelDescription& arm);

}  // namespace veridyn
