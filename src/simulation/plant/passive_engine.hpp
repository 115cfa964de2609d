#pragma once

#include <memory>

#include "veridyn/simulation/engine.hpp"

namespace veridyn {

/// The first `joints` coordinates of an engine's arm, behind which others move without motors: the
/// states of effects on the whole arm. set_state() puts these where they are in balance.
/// @param whole  the model that `engine` moves, with values.
std::unique_ptr<Engine> make_passive_engine(std::unique_ptr<Engine> engine, const Model& whole,
                                            int joints);

}  // namespace veridyn
