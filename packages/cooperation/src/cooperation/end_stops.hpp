#pragma once

#include "veridyn/model/model.hpp"
#include "veridyn/simulation/world.hpp"

namespace veridyn {

/// Puts joints beyond the end of their range back to it, at rest: a stop without rebound.
void stop_at_ends(World& world, const Model& model, int arm);

}  // namespace veridyn
