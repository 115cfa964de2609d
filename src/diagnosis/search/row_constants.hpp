#pragma once

#include <string>
#include <vector>

#include "effects/kinematic_error.hpp"

namespace veridyn {

/// All DH numbers and joint coefficients of frames that move a body, without constants that have no
/// effect.
std::vector<FrameConstant> row_constants(const Model& arm);

/// The value in the robot file.
double value_in(const Model& arm, const FrameConstant& constant);

/// The arm with one constant replaced.
Model with_constant(const Model& arm, const FrameConstant& constant, double value);

/// "theta of frame counterweight_rail".
std::string words_for(const Model& arm, const FrameConstant& constant);

}  // namespace veridyn
