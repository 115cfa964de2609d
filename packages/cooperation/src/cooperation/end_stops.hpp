#pragma once

#include "veridyn/model/model.hpp"
#include "veridyn/simulation/world.hpp"

namespace veridyn {

/// Stops a joint that has reached the end of its range, without rebound.
void stop_at_ends(World& world, const Model& model, int arm);

}  // namespace veridyn
