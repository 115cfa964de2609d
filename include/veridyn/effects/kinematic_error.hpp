#pragma once

#include <string>
#include <utility>
#include <vector>

#include "veridyn/effects/cause.hpp"

namespace veridyn {

/// All numbers that determine the pose of a frame: those of its DH row or of its joint's origin, then all ratios.
std::vector<FrameConstant> constants_of(const Model& arm, FrameIndex frame);

/// Name of a constant: "theta", "yaw", "ratio of pitch".
std::string name_of(const Model& arm, const FrameConstant& constant);

/// "rad", "m", or "1" for a ratio.
std::string unit_of(const FrameConstant& constant);

/// The key of its formula in ModelDescription::formulas: "frames/elbow/dh/0".
std::string formula_key(const Model& arm, const FrameConstant& constant);

/// The present value of a wrong constant; zero for a joint's zero. Constants with a name are not
/// supported, because other numbers depend on them.
double value_of(const KinematicError& error, const ModelDescription& arm);

/// Sets that value in `arm`. A zero shifts all joint variables that contain its coordinate.
void set_value(const KinematicError& error, double value, ModelDescription& arm);

/// Sets numbers of frames at once; of two values for one number the later one is used.
void set_values(const std::vector<std::pair<FrameConstant, double>>& values, ModelDescription& arm);

}  // namespace veridyn
