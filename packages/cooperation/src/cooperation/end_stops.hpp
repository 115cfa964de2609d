#pragma once

#include "veridyn/model/model.hpp"
#include "veridyn/simulation/world.hpp"

namespace veridyn {

/// An arm that has come to the end of a joint's range stays there, without rebound.
void stop_at_ends(World& world, const Model& model, int arm);

}  // namespace veridyn
