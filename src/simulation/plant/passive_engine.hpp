#pragma once

#include <memory>

#include "veridyn/simulation/engine.hpp"

namespace veridyn {

/// Presents the first `joints` coordinates of an engine's arm; the others move without motors: they
/// are states of effects on the whole arm. set_state() puts these into equilibrium.
/// @param whole  the model of `engine`, with values.
std::unique_ptr<Engine> make_passive_engine(std::unique_ptr<Engine> engine, const Model& whole,
                                            int joints);

}  // namespace veridyn
