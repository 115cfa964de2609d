#pragma once

#include "veridyn/model/model.hpp"

namespace veridyn {

/// The arm with every base parameter wrong by `share`, up or down at random: what a controller
/// knows of it. Base parameters, because torques depend on nothing else: the single parameters
/// behind them may cancel out by the hundred.
Model with_parameter_errors(const Model& arm, double share, unsigned seed);

}  // namespace veridyn
