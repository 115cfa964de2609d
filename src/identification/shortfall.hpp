#pragma once

#include <string>
#include <vector>

#include "veridyn/identification/compressed_recording.hpp"
#include "veridyn/identification/base_parameters.hpp"

namespace veridyn {

/// Names of the coordinates that never move in any recording.
std::vector<std::string> still_joints(const Model& arm,
                                      const std::vector<CompressedRecording>& recordings);

/// Reason for which recordings do not determine the base parameters of their arm: joints that never move,
/// else the number of determined parameters. Empty if all are determined.
/// @param arm_base   of the arm. @param data_base  of the recordings' factor.
std::string shortfall(const BaseParameters& arm_base, const BaseParameters& data_base,
                      const std::vector<std::string>& still);

}  // namespace veridyn
