#pragma once

#include "veridyn/model/model.hpp"

namespace veridyn {

/// Values of bodies, ten each, then of effects; zero where an effect has none.
/// @throws InvalidInput  a body has no values.
VectorXd standard_values(const Model& arm);

}  // namespace veridyn
